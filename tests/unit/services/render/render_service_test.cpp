#include "render/render_service.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "../../render/scene.hpp"
#include "base/utime.hpp"
#include "bus/endpoint.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {
namespace {

/// Tile stores of one process: a map of tiles, and what was asked of it.
struct MapOfTiles {
  std::map<TileKey, std::pair<std::uint64_t, Bytes>> tiles;
  std::set<TileKey> silent;  ///< Tiles that never come.
  bool lists = true;
  int listed = 0;
  std::vector<TileKey> fetched;

  explicit MapOfTiles(const test::Scene& scene) {
    for (const auto& [key, tree] : scene.tiles()) tiles[key] = {1, encode_tile(tree, {})};
  }

  TileSource source() {
    TileSource source;
    source.list = [this](const TileRange& range, std::int64_t) -> Result<std::vector<ListedTile>> {
      ++listed;
      if (!lists) return fail(ErrorCode::kUnavailable, "tilestore 0 has not answered");
      std::vector<ListedTile> found;
      for (const auto& [key, tile] : tiles) {
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          inside = inside && key.index()[axis] >= range.min[axis] &&
                   key.index()[axis] <= range.max[axis];
        }
        if (inside) found.push_back({key, tile.first});
      }
      return found;
    };
    source.fetch = [this](const std::vector<TileKey>& keys, std::int64_t,
                          const std::function<void(ArrivedTile)>& arrived) -> Status {
      bool all = true;
      for (const TileKey key : keys) {
        fetched.push_back(key);
        all = all && !silent.contains(key);
        if (silent.contains(key)) continue;
        arrived({key, tiles.at(key).first, tiles.at(key).second});
      }
      if (!all) return fail(ErrorCode::kUnavailable, "some tiles did not come");
      return {};
    };
    return source;
  }
};

camera_t message_of(const Camera& camera) {
  camera_t message{};
  for (int axis = 0; axis < 3; ++axis) message.position[axis] = camera.position()[axis];
  message.orientation[0] = camera.orientation().w();
  message.orientation[1] = camera.orientation().x();
  message.orientation[2] = camera.orientation().y();
  message.orientation[3] = camera.orientation().z();
  const Lens& lens = camera.lens();
  message.fx = lens.fx;
  message.fy = lens.fy;
  message.cx = lens.cx;
  message.cy = lens.cy;
  message.width = lens.width;
  message.height = lens.height;
  message.near_range = lens.near_range;
  message.far_range = lens.far_range;
  return message;
}

struct Bench {
  test::Scene scene = test::street_scene();
  Camera camera = scene.camera({-20, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200)).value();
  MapOfTiles map{scene};
  std::unique_ptr<RenderService> service;

  explicit Bench(const RenderConfig& config = {}) {
    service = RenderService::create(scene.grid(), map.source(), config).value();
  }

  render_request_t request() const {
    render_request_t request{};
    request.client = 77;
    request.id = 5;
    request.camera = message_of(camera);
    request.depth = 7;
    request.colouring = "rgb";
    return request;
  }

  frame_t frame(const render_request_t& request) {
    service->on_request(request);
    auto out = service->work();
    REQUIRE(out.has_value());
    return out->frame;
  }
};

TEST_CASE("a PNG frame is the picture of the tiles themselves", "[render][oracle]") {
  Bench bench;
  auto request = bench.request();
  request.format = 1;
  request.reply_port = Endpoint::create(EndpointClass::kClient, 3)->port_offset();
  bench.service->on_request(request);
  const auto out = bench.service->work();
  REQUIRE(out.has_value());
  const frame_t& frame = out->frame;
  REQUIRE(out->reply_port == request.reply_port);
  REQUIRE(frame.error.empty());
  REQUIRE(frame.client == 77);
  REQUIRE(frame.id == 5);
  REQUIRE(frame.final == 1);
  REQUIRE(frame.size == static_cast<std::int32_t>(frame.data.size()));

  // Oracle: drawn straight from the trees, in the order the frustum gives.
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  std::vector<CellCloud> clouds;
  std::vector<PlacedCloud> placed;
  clouds.reserve(keys.size());
  for (const TileKey key : keys) {
    clouds.emplace_back(bench.scene.tiles().at(key), 7);
    placed.push_back({key, &clouds.back()});
  }
  auto maker = PictureMaker::create().value();
  const auto picture = maker->make(bench.camera, bench.scene.grid(), placed, {});
  REQUIRE(decode_png(frame.data).value() == picture->image);
  REQUIRE(frame.tiles == static_cast<std::int32_t>(keys.size()));
  REQUIRE(frame.tiles_missing == 0);
  REQUIRE(frame.newest_version == 1);
  REQUIRE(frame.cells == static_cast<std::int64_t>(picture->cells_drawn));
  REQUIRE(frame.draw_ms > 0);
}

TEST_CASE("a broadcast frame is a JPEG that fits and says its quality", "[render]") {
  RenderConfig config;
  config.jpeg_bytes = 9'000;
  Bench bench(config);
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.data.size() <= 9'000);
  REQUIRE(frame.data[0] == 0xff);
  REQUIRE(frame.data[1] == 0xd8);
  REQUIRE(frame.quality > 0);
  REQUIRE(frame.quality < 85);
  config.jpeg_bytes = 100;
  Bench tight(config);
  REQUIRE_THAT(tight.frame(tight.request()).error, Catch::Contains("320 x 200"));
}

TEST_CASE("a tile is fetched once, and again when it has changed", "[render]") {
  Bench bench;
  (void)bench.frame(bench.request());
  const std::size_t all = bench.map.fetched.size();
  REQUIRE(all > 4);
  (void)bench.frame(bench.request());
  REQUIRE(bench.map.fetched.size() == all);

  const TileKey changed = bench.map.fetched.front();
  auto& stored = bench.map.tiles.at(changed);
  stored = {2, encode_tile(TileTree(), {})};
  tile_update_t update{};
  update.tile = static_cast<std::int64_t>(changed.morton());
  update.version = 2;
  bench.service->on_tile_update(update);
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(bench.map.fetched.size() == all + 1);
  REQUIRE(bench.map.fetched.back() == changed);
  REQUIRE(frame.newest_version == 2);
  REQUIRE(frame.tiles_missing == 0);
}

TEST_CASE("updates that cannot be meant change nothing", "[render]") {
  Bench bench;
  (void)bench.frame(bench.request());
  const std::size_t all = bench.map.fetched.size();
  for (const std::int64_t key : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    tile_update_t update{};
    update.tile = key;
    update.version = 9;
    bench.service->on_tile_update(update);
  }
  tile_update_t negative{};
  negative.tile = static_cast<std::int64_t>(bench.map.fetched.front().morton());
  negative.version = -5;
  bench.service->on_tile_update(negative);
  REQUIRE(bench.frame(bench.request()).tiles_missing == 0);
  REQUIRE(bench.map.fetched.size() == all);
}

TEST_CASE("a tile that does not come is counted, and the rest is drawn", "[render]") {
  Bench bench;
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  bench.map.silent = {keys[1]};
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles_missing == 1);
  REQUIRE(frame.tiles == static_cast<std::int32_t>(keys.size()) - 1);
  bench.map.silent.clear();
  REQUIRE(bench.frame(bench.request()).tiles_missing == 0);
}

TEST_CASE("a changed tile that does not come is drawn as it was, and counted", "[render]") {
  Bench bench;
  const frame_t before = bench.frame(bench.request());
  const TileKey changed = bench.map.fetched.front();
  bench.map.silent = {changed};
  tile_update_t update{};
  update.tile = static_cast<std::int64_t>(changed.morton());
  update.version = 2;
  bench.service->on_tile_update(update);
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.tiles == before.tiles);
  REQUIRE(frame.tiles_missing == 1);
}

TEST_CASE("bytes that are no tile are counted as missing, not drawn", "[render]") {
  Bench bench;
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  bench.map.tiles.at(keys[0]).second = {1, 2, 3};
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles_missing == 1);
  REQUIRE(frame.tiles == static_cast<std::int32_t>(keys.size()) - 1);
}

TEST_CASE("without an answer from the stores a frame says so", "[render]") {
  Bench bench;
  bench.map.lists = false;
  const frame_t frame = bench.frame(bench.request());
  REQUIRE_THAT(frame.error, Catch::Contains("tilestore 0"));
  REQUIRE(frame.data.empty());
  REQUIRE(frame.id == 5);
}

TEST_CASE("a view with nothing in it is a picture of the sky", "[render]") {
  Bench bench;
  auto request = bench.request();
  request.camera.position[0] += 50'000;
  const frame_t frame = bench.frame(request);
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles == 0);
  REQUIRE(frame.cells == 0);
  REQUIRE_FALSE(frame.data.empty());
}

TEST_CASE("a bad request is answered by a frame that says what is bad", "[render]") {
  Bench bench;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change, const std::string& word) {
    auto request = bench.request();
    change(request);
    const frame_t frame = bench.frame(request);
    CAPTURE(frame.error);
    REQUIRE_THAT(frame.error, Catch::Contains(word));
    REQUIRE(frame.data.empty());
    REQUIRE(frame.size == 0);
    REQUIRE(frame.id == request.id);
  };
  using R = render_request_t;
  refused([&](R& r) { r.camera.position[1] = nan; }, "nan");
  refused([&](R& r) { r.camera.orientation[0] = nan; }, "nan");
  refused([](R& r) { std::fill_n(r.camera.orientation, 4, 0.0); }, "length 0");
  refused([](R& r) { r.camera.width = 0; }, "0 x 200");
  refused([](R& r) { r.camera.height = 100'000; }, "100000");
  refused([](R& r) { r.camera.near_range = 0; }, "near");
  refused([](R& r) { r.colouring = "plaid"; }, "plaid");
  refused([](R& r) { r.depth = 9; }, "depth 9");
  refused([](R& r) { r.depth = -1; }, "depth -1");
  refused([](R& r) { r.format = 7; }, "format 7");
  refused([](R& r) { r.format = 1; }, "port");
  REQUIRE(bench.map.listed == 0);
  REQUIRE(bench.frame(bench.request()).error.empty());  // And goes on.
}

TEST_CASE("a thousand requests of one client are one picture, and another's turn comes",
          "[render]") {
  Bench bench;
  auto request = bench.request();
  for (request.id = 1; request.id <= 1000; ++request.id) bench.service->on_request(request);
  auto other = bench.request();
  other.client = 78;
  bench.service->on_request(other);
  const auto first = bench.service->work();
  REQUIRE(first->frame.client == 77);
  REQUIRE(first->frame.id == 1000);
  const auto second = bench.service->work();
  REQUIRE(second->frame.client == 78);
  REQUIRE(second->frame.sequence == first->frame.sequence + 1);
  REQUIRE(bench.service->idle());
  REQUIRE_FALSE(bench.service->work().has_value());
}

TEST_CASE("a request past its deadline is not drawn", "[render]") {
  Bench bench;
  auto request = bench.request();
  request.deadline = utime_now() - 1;
  bench.service->on_request(request);
  REQUIRE_FALSE(bench.service->work().has_value());
  REQUIRE(bench.map.listed == 0);
  request.deadline = utime_now() + 60'000'000;
  REQUIRE(bench.frame(request).error.empty());
}

TEST_CASE("a picture larger than the cache shows what fits and counts the rest", "[render]") {
  RenderConfig config;
  config.cache_bytes = 1;
  Bench bench(config);
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  // One batch is always drawn; this scene may have no more.
  REQUIRE(frame.tiles + frame.tiles_missing == static_cast<std::int32_t>(keys.size()));
  REQUIRE(frame.tiles > 0);
}

TEST_CASE("coarser pictures have fewer cells", "[render]") {
  Bench bench;
  std::int64_t cells = std::numeric_limits<std::int64_t>::max();
  for (std::int8_t depth = 7; depth >= 0; --depth) {
    auto request = bench.request();
    request.depth = depth;
    const frame_t frame = bench.frame(request);
    REQUIRE(frame.error.empty());
    REQUIRE(frame.depth == depth);
    REQUIRE(frame.cells < cells);
    cells = frame.cells;
  }
}

}  // namespace
}  // namespace voxatlas
