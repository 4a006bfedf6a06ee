#include "render/render_service.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "bus/endpoint.hpp"
#include "render_bench.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a PNG frame is the picture of the tiles themselves", "[render][oracle]") {
  test::RenderBench bench;
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
  std::vector<RenderTree> trees;
  std::vector<PlacedTree> placed;
  std::uint64_t cells_to_draw = 0;
  trees.reserve(keys.size());
  for (const TileKey key : keys) {
    trees.emplace_back(bench.scene.tiles().at(key));
    placed.push_back({key, &trees.back()});
    cells_to_draw += trees.back().cell_count(7);
  }
  const Grid& grid = bench.scene.grid();
  Splatter splatter(1);
  CellImage cells;
  REQUIRE(splatter.draw(bench.camera, grid, placed, {}, cells).has_value());
  const Image image =
      shade(cells, TreeNumbers(placed), bench.camera, grid,
            scene_heights(bench.camera, grid, placed), Colouring::kRgb, splatter.workers());
  REQUIRE(decode_png(frame.data).value() == image);
  REQUIRE(frame.tiles == static_cast<std::int32_t>(keys.size()));
  REQUIRE(frame.tiles_missing == 0);
  REQUIRE(frame.newest_version == 1);
  REQUIRE(frame.cells == static_cast<std::int64_t>(cells_to_draw));
  REQUIRE(frame.draw_ms > 0);
}

TEST_CASE("a broadcast frame is a JPEG that fits and says its quality", "[render]") {
  RenderConfig config;
  config.jpeg_bytes = 9'000;
  test::RenderBench bench(config);
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.data.size() <= 9'000);
  REQUIRE(frame.data[0] == 0xff);
  REQUIRE(frame.data[1] == 0xd8);
  REQUIRE(frame.quality > 0);
  REQUIRE(frame.quality < 85);
  config.jpeg_bytes = 100;
  test::RenderBench tight(config);
  REQUIRE_THAT(tight.frame(tight.request()).error, Catch::Contains("320 x 200"));
}

TEST_CASE("a tile is fetched once, and again when it has changed", "[render]") {
  test::RenderBench bench;
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
  test::RenderBench bench;
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
  test::RenderBench bench;
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
  test::RenderBench bench;
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
  test::RenderBench bench;
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  bench.map.tiles.at(keys[0]).second = {1, 2, 3};
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles_missing == 1);
  REQUIRE(frame.tiles == static_cast<std::int32_t>(keys.size()) - 1);
}

TEST_CASE("without an answer from the stores a frame says so", "[render]") {
  test::RenderBench bench;
  bench.map.lists = false;
  const frame_t frame = bench.frame(bench.request());
  REQUIRE_THAT(frame.error, Catch::Contains("tilestore 0"));
  REQUIRE(frame.data.empty());
  REQUIRE(frame.id == 5);
}

TEST_CASE("a view with nothing in it is a picture of the sky", "[render]") {
  test::RenderBench bench;
  auto request = bench.request();
  request.camera.position[0] += 50'000;
  const frame_t frame = bench.frame(request);
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles == 0);
  REQUIRE(frame.cells == 0);
  REQUIRE_FALSE(frame.data.empty());
}

TEST_CASE("a picture larger than the cache shows what fits and counts the rest", "[render]") {
  RenderConfig config;
  config.cache_bytes = 1;
  test::RenderBench bench(config);
  const auto keys = tiles_in_view(bench.camera, bench.scene.grid(), bench.scene.keys());
  const frame_t frame = bench.frame(bench.request());
  REQUIRE(frame.error.empty());
  // One batch is always drawn; this scene may have no more.
  REQUIRE(frame.tiles + frame.tiles_missing == static_cast<std::int32_t>(keys.size()));
  REQUIRE(frame.tiles > 0);
}

TEST_CASE("coarser pictures have fewer cells", "[render]") {
  test::RenderBench bench;
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
