#include "render/render_service.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "render_world.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Hits at a few voxels of a tile: something new to be seen.
TileDelta some_hits(std::uint32_t first) {
  TileDelta delta;
  for (std::uint32_t i = 0; i < 200; ++i) {
    delta.hits.insert({kDepth, (first + i * 7919) % 2'097'152});
  }
  return delta;
}

TEST_CASE("a PNG frame is the picture of the tiles themselves", "[render][oracle]") {
  test::RenderWorld world;
  const auto request = world.request();
  const frame_t frame = world.frame(request);
  REQUIRE(frame.error.empty());
  REQUIRE(world.frames.back().reply_port == request.reply_port);
  REQUIRE(frame.id == 5);
  REQUIRE(frame.final == 1);
  REQUIRE(frame.sequence == 0);
  REQUIRE(frame.depth == 7);
  REQUIRE(frame.samples == 1);
  REQUIRE(frame.size == static_cast<std::int32_t>(frame.data.size()));
  REQUIRE(decode_png(frame.data).value() == world.painted(world.camera));
  REQUIRE(frame.tiles > 4);
  REQUIRE(frame.tiles_missing == 0);
  REQUIRE(frame.newest_version == 1);
  REQUIRE(frame.cells > 1000);
  REQUIRE(frame.shown_until > 1'700'000'000'000'000);
}

TEST_CASE("a broadcast frame is a JPEG that fits and says its quality", "[render]") {
  test::RenderWorld::Setting setting;
  setting.config.limits.jpeg_bytes = 9'000;
  test::RenderWorld world(setting);
  const frame_t frame = world.frame(world.broadcast());
  REQUIRE(world.frames.back().reply_port == 0);
  REQUIRE(frame.error.empty());
  REQUIRE(frame.data.size() <= 9'000);
  REQUIRE(frame.data[0] == 0xff);
  REQUIRE(frame.data[1] == 0xd8);
  REQUIRE(frame.quality > 0);
  REQUIRE(frame.quality < 85);
  setting.config.limits.jpeg_bytes = 100;
  test::RenderWorld tight(setting);
  const frame_t refused = tight.frame(tight.broadcast());
  REQUIRE_THAT(refused.error, Catch::Contains("320 x 200"));
  REQUIRE(refused.last == 1);
}

TEST_CASE("raw pictures and depth images come by stream", "[render][oracle]") {
  test::RenderWorld world;
  auto request = world.request();
  request.format = 2;
  request.depth_format = 2;
  const frame_t metres = world.frame(request);
  const Image oracle = world.painted(world.camera);
  REQUIRE(metres.data.size() == 3 * oracle.pixels.size());
  REQUIRE(std::memcmp(metres.data.data(), oracle.pixels.data(), metres.data.size()) == 0);
  REQUIRE(metres.depth_data.size() == 4 * oracle.pixels.size());
  request.id = 6;
  request.depth_format = 1;
  const frame_t steps = world.frame(request);
  REQUIRE(steps.depth_data.size() == 2 * oracle.pixels.size());
  std::size_t sky = 0;
  for (std::size_t i = 0; i < oracle.pixels.size(); ++i) {
    float z = 0;
    std::uint16_t step = 0;
    std::memcpy(&z, metres.depth_data.data() + 4 * i, 4);
    std::memcpy(&step, steps.depth_data.data() + 2 * i, 2);
    if (std::isinf(z)) {
      ++sky;
      REQUIRE(step == 0);
    } else {
      REQUIRE(std::abs(step * steps.depth_scale - static_cast<double>(z)) <= steps.depth_scale);
    }
  }
  REQUIRE(sky > 0);
  REQUIRE(sky < oracle.pixels.size() / 2);
}

TEST_CASE("coarse trees are built before fine ones, nearest first, each tile fetched once",
          "[render]") {
  test::RenderWorld world;
  (void)world.frame(world.request());
  const auto keys = world.in_view();
  REQUIRE(world.fetched.size() >= keys.size());
  std::set<TileKey> distinct(world.fetched.begin(), world.fetched.end());
  REQUIRE(distinct == std::set<TileKey>(keys.begin(), keys.end()));
  std::map<TileKey, int> times;
  for (const auto& [key, depth] : world.built) {
    REQUIRE(depth == (times[key]++ == 0 ? TreeCache::kCoarse : kDepth));
  }
  for (const TileKey key : keys) REQUIRE(times[key] >= 3);  // And normals across borders.

  auto again = world.request();
  again.id = 6;
  const std::size_t fetched = world.fetched.size(), built = world.built.size();
  (void)world.frame(again);
  REQUIRE(world.fetched.size() == fetched);
  REQUIRE(world.built.size() == built);
}

TEST_CASE("with loss, duplicates and late answers all tiles come", "[render]") {
  test::RenderWorld::Setting setting;
  setting.faults = {0.2, 0.1, 500, 3'000};
  test::RenderWorld world(setting);
  INFO("VOX_SEED=" << test::seed());
  const frame_t frame = world.frame(world.request());
  REQUIRE(frame.tiles_missing == 0);
  REQUIRE(decode_png(frame.data).value() == world.painted(world.camera));
}

TEST_CASE("a tile that changes is shown as it is, by its changes where they are told",
          "[render][oracle]") {
  const int content = GENERATE(1, 0, -1);
  test::RenderWorld world;
  (void)world.frame(world.request());
  const TileKey key = world.in_view()[1];
  auto request = world.request();
  for (std::uint32_t i = 0; i < 4; ++i) {
    world.change(key, some_hits(1000 * i), i % 2 == 1 ? content : 1);
    world.run(1'100'000);  // An update may be lost: a listing tells after a second.
    request.id = 10 + i;
    const frame_t frame = world.frame(request);
    CAPTURE(i, content);
    REQUIRE(frame.tiles_missing == 0);
    REQUIRE(frame.newest_version == static_cast<std::int64_t>(world.stored.at(key).first));
    REQUIRE(decode_png(frame.data).value() == world.painted(world.camera));
  }
}

TEST_CASE("while a tile changes only its changes go over the wire", "[render]") {
  test::RenderWorld world;
  auto request = world.request();
  (void)world.frame(request);
  const TileKey key = world.in_view()[1];
  for (std::uint32_t i = 0; i < 20; ++i) {
    world.change(key, some_hits(1000 * i), 1);
    world.run(1'000);
    request.id = 100 + i;
    (void)world.frame(request);
  }
  REQUIRE(std::count(world.fetched.begin(), world.fetched.end(), key) <=
          16);  // Coarse, and twice, in ranges.
  REQUIRE(decode_png(world.frames.back().frame.data).value() == world.painted(world.camera));
}

TEST_CASE("a tile that does not come is counted, and the rest is drawn", "[render]") {
  test::RenderWorld world;
  const auto keys = world.in_view();
  world.silent = {keys[1]};
  const frame_t frame = world.frame(world.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles_missing == 1);
  REQUIRE(frame.wait_ms >= 3'000);
  world.silent.clear();
  auto again = world.request();
  again.id = 6;
  REQUIRE(world.frame(again).tiles_missing == 0);
}

TEST_CASE("bytes that are no tile are not asked for again and again", "[render]") {
  test::RenderWorld world;
  const TileKey key = world.in_view()[0];
  tile_update_t update{};
  update.utime = world.now.utime;
  update.tile = static_cast<std::int64_t>(key.morton());
  update.version = 9;
  (void)world.frame(world.request());
  auto request = world.request();
  request.id = 6;
  // A delta that is none: the tile is fetched whole, as the store has it.
  update.version = 2;
  update.content = 1;
  update.payload = {9, 9, 9};
  update.size = 3;
  world.stored.at(key).first = 2;
  world.tell(update);
  world.run(1'000);
  const frame_t frame = world.frame(request);
  REQUIRE(frame.tiles_missing == 0);
  REQUIRE(decode_png(frame.data).value() == world.painted(world.camera));
}

TEST_CASE("without an answer from the stores a frame says so", "[render]") {
  test::RenderWorld world;
  world.stores_answer = false;
  const frame_t frame = world.frame(world.request());
  REQUIRE_THAT(frame.error, Catch::Contains("stores"));
  REQUIRE(frame.data.empty());
  REQUIRE(frame.id == 5);
}

TEST_CASE("a view with nothing in it is a picture of the sky", "[render]") {
  test::RenderWorld world;
  auto request = world.request();
  const double off = GENERATE(5e4, -6e6, 4e6);  // Elsewhere, in the Earth, off the grid.
  request.camera.position[0] += off;
  const frame_t frame = world.frame(request);
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles == 0);
  REQUIRE(frame.cells == 0);
  REQUIRE_FALSE(frame.data.empty());
}

TEST_CASE("a picture larger than the cache shows its nearest tiles and counts the rest",
          "[render]") {
  test::RenderWorld::Setting setting;
  setting.config.cache_bytes = 60'000;
  test::RenderWorld world(setting);
  const auto keys = world.in_view();
  const frame_t frame = world.frame(world.request());
  REQUIRE(frame.error.empty());
  REQUIRE(frame.tiles > 0);
  REQUIRE(frame.tiles_missing > 0);
  REQUIRE(frame.tiles + frame.tiles_missing <= static_cast<std::int32_t>(keys.size()));
  REQUIRE(frame.wait_ms < 2'000);
}

TEST_CASE("coarser pictures have fewer cells", "[render]") {
  test::RenderWorld world;
  std::int64_t cells = std::numeric_limits<std::int64_t>::max();
  auto request = world.request();
  for (request.depth = 7; request.depth >= 0; --request.depth) {
    ++request.id;
    const frame_t frame = world.frame(request);
    REQUIRE(frame.error.empty());
    REQUIRE(frame.depth <= request.depth);
    REQUIRE(frame.cells < cells);
    cells = frame.cells;
  }
}

TEST_CASE("of several renderers one answers each client, and another when it has died",
          "[render]") {
  test::RenderWorld::Setting setting;
  setting.renderers = 3;
  test::RenderWorld world(setting);
  std::map<std::int64_t, std::int32_t> who;
  auto request = world.broadcast();
  for (request.client = 1; request.client <= 30; ++request.client) {
    (void)world.frame(request);
    const auto theirs = world.frames_of(request.client);
    REQUIRE(theirs.size() == 1);
    who[request.client] = theirs.front().renderer;
  }
  std::set<std::int32_t> renderers;
  for (const auto& [client, renderer] : who) renderers.insert(renderer);
  REQUIRE(renderers.size() == 3);

  world.dead = {1};
  world.run(RendererRoll::kAlive + 600'000);
  request.id = 6;
  for (request.client = 1; request.client <= 30; ++request.client) {
    const frame_t frame = world.frame(request);
    REQUIRE(world.frames_of(request.client).size() == 2);
    REQUIRE(frame.renderer != 1);
    if (who[request.client] != 1) REQUIRE(frame.renderer == who[request.client]);
  }
}

}  // namespace
}  // namespace voxatlas
