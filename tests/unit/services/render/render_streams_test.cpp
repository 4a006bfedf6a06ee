#include <algorithm>

#include "render_world.hpp"

namespace voxatlas {
namespace {

TEST_CASE("within a budget pictures get better, up to that of no budget and beyond",
          "[render][oracle]") {
  test::RenderWorld world;
  auto request = world.request();
  request.budget_ms = 1;
  const frame_t last = world.frame(request);
  const auto frames = world.frames_of(77);
  REQUIRE(frames.size() >= 3);
  std::int64_t pixels = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const frame_t& frame = frames[i];
    CAPTURE(i);
    REQUIRE(frame.error.empty());
    REQUIRE(frame.sequence == static_cast<std::int64_t>(i));
    REQUIRE((frame.final == 1) == (i + 1 == frames.size()));
    REQUIRE(frame.last == frame.final);
    const std::int64_t now = std::int64_t{frame.camera.width} * frame.camera.height;
    REQUIRE(now >= pixels);
    pixels = now;
  }
  REQUIRE(frames[0].camera.width < 320);
  REQUIRE(last.samples == 4);
  const frame_t& full = frames[frames.size() - 2];
  REQUIRE(full.samples == 1);
  REQUIRE(full.threshold == 0);
  REQUIRE(decode_png(full.data).value() == world.painted(world.camera));
  REQUIRE(decode_png(last.data).value() != world.painted(world.camera));
  REQUIRE(last.over_budget >= 0);
}

TEST_CASE("pictures that take longer than their budget are counted", "[render]") {
  test::RenderWorld world;
  auto request = world.request();
  request.budget_ms = 5;       // A picture takes 20 ms here, however small.
  (void)world.frame(request);  // Now all tiles are here.
  ++request.id;
  REQUIRE(world.frame(request).over_budget == 1);
}

/// A stream of a camera that rests, 10 a second for 5 s.
render_request_t resting(const test::RenderWorld& world) {
  auto request = world.broadcast();
  request.kind = 1;
  request.rate = 10;
  request.deadline = world.now.utime + 5'000'000;
  return request;
}

TEST_CASE("a stream shows what changes, and nothing where nothing does", "[render]") {
  test::RenderWorld world;
  world.ask(resting(world));
  world.run(2'000'000);
  const std::size_t at_rest = world.frames.size();
  REQUIRE(at_rest >= 1);
  REQUIRE(world.frames.back().frame.final == 1);
  REQUIRE(world.frames.back().frame.last == 0);
  world.run(1'000'000);
  REQUIRE(world.frames.size() == at_rest);

  TileDelta delta;
  delta.hits.insert({kDepth, 12345});
  const std::int64_t changed = world.now.steady, changed_utime = world.now.utime;
  world.change(world.in_view()[0], delta, 1);
  REQUIRE(world.run(500'000, [&] {
    return world.frames.back().frame.newest_version == 2 &&
           world.frames.back().frame.shown_until >= changed_utime;
  }));
  REQUIRE(world.now.steady - changed < 200'000);
  world.run(10'000'000);
  REQUIRE(world.arrived_at.back() < changed + 2'000'000);  // The deadline has ended it.
}

TEST_CASE("a stream keeps to its rate while everything changes", "[render]") {
  test::RenderWorld world;
  world.ask(resting(world));
  world.run(1'000'000);
  const std::size_t before = world.frames.size();
  const auto keys = world.in_view();
  for (std::uint32_t i = 0; i < 100; ++i) {
    TileDelta delta;
    delta.hits.insert({kDepth, i * 977});
    world.change(keys[i % keys.size()], delta, 1);
    world.run(10'000);
  }
  const std::size_t frames = world.frames.size() - before;
  REQUIRE(frames >= 7);
  REQUIRE(frames <= 12);
}

TEST_CASE("a stream shows what it was told of by then, however long that had been durable",
          "[render]") {
  constexpr std::int64_t kWithinItsCommit = 300'000;
  test::RenderWorld world;
  world.ask(resting(world));
  world.run(1'000'000);
  const auto keys = world.in_view();
  const std::size_t before = world.frames.size();
  for (std::uint32_t i = 0; i < 300; ++i) {
    TileDelta delta;
    delta.hits.insert({kDepth, i * 977});
    auto update = world.change(keys[i % keys.size()], delta, -1);
    update.utime -= kWithinItsCommit;
    world.tell(update);
    world.run(3'000);
  }
  REQUIRE(world.frames.size() > before + 5);
  std::size_t behind = 0;  // Some frames are begun with changes that are not shown.
  for (std::size_t i = before; i < world.frames.size(); ++i) {
    const frame_t& frame = world.frames[i].frame;
    REQUIRE(frame.shown_until > frame.utime - 100'000);
    behind += frame.tiles_missing > 0;
  }
  REQUIRE(behind > 3);
}

TEST_CASE("a stream looks across borders once what is around a tile has come to rest", "[render]") {
  test::RenderWorld world;
  world.ask(resting(world));
  world.run(1'000'000);
  const int before = world.bordered;
  REQUIRE(before > 0);
  const TileKey key = world.in_view()[0];
  for (std::uint32_t i = 0; i < 100; ++i) {
    TileDelta delta;
    delta.hits.insert({kDepth, i * 977});
    world.change(key, delta, 1);
    world.run(10'000);
  }
  REQUIRE(world.bordered == before);
  world.run(1'000'000);
  REQUIRE(world.bordered > before);
  REQUIRE(world.frames.back().frame.final == 1);
}

TEST_CASE("a stream waits for changes that a listing has overtaken", "[render]") {
  test::RenderWorld world;
  world.ask(resting(world));
  world.run(1'000'000);
  const std::size_t fetched = world.fetched.size(), before = world.frames.size();
  const int listed = world.listed;
  const TileKey key = world.in_view()[0];
  std::vector<tile_update_t> late;
  for (std::uint32_t i = 0; i < 300; ++i) {
    TileDelta delta;
    delta.hits.insert({kDepth, i * 977});
    late.push_back(world.change(key, delta, -1));
    world.run(10'000);
    if (i >= 6) world.tell(late[i - 6]);
  }
  REQUIRE(world.listed >= listed + 2);
  REQUIRE(world.fetched.size() == fetched);
  for (std::size_t i = before; i < world.frames.size(); ++i) {
    const frame_t& frame = world.frames[i].frame;
    REQUIRE(frame.shown_until > frame.utime - 200'000);
  }
  world.run(1'000'000);  // The last six were lost.
  REQUIRE(world.fetched.size() > fetched);
  REQUIRE(world.frames.back().frame.newest_version == late.back().version);
}

render_request_t along_a_path(const test::RenderWorld& world, double seconds, double rate) {
  auto request = world.request();
  request.kind = 1;
  request.rate = rate;
  request.budget_ms = 0;
  ByteWriter path(request.path);
  for (int row = 0; row < 2; ++row) {
    path.put(row * seconds);
    const Eigen::Vector3d p =
        world.camera.position() + row * 10 * (world.camera.rotation().row(2).transpose());
    for (int axis = 0; axis < 3; ++axis) path.put(p[axis]);
    const auto& q = world.camera.orientation();
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) path.put(x);
  }
  request.path_size = static_cast<std::int32_t>(request.path.size());
  return request;
}

TEST_CASE("along a path a client gets every picture by stream, whole and in order",
          "[render][oracle]") {
  test::RenderWorld world;
  world.paint_us = 100'000;  // Later than the path goes, 25 a second.
  const auto request = along_a_path(world, 1, 25);
  (void)world.frame(request);
  const auto frames = world.frames_of(77);
  REQUIRE(frames.size() == 26);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    REQUIRE(frames[i].place == static_cast<std::int32_t>(i));
    REQUIRE(frames[i].tiles_missing == 0);
    REQUIRE((frames[i].last == 1) == (i == 25));
  }
  const auto camera = to_camera(frames[10].camera).value();
  const Eigen::Vector3d went = camera.position() - world.camera.position();
  REQUIRE(went.norm() == Approx(4));
  REQUIRE(decode_png(frames[10].data).value() == world.painted(camera));
}

TEST_CASE("a path goes on where it is asked to", "[render]") {
  test::RenderWorld world;
  auto request = along_a_path(world, 1, 25);
  request.first = 20;
  (void)world.frame(request);
  const auto frames = world.frames_of(77);
  REQUIRE(frames.size() == 6);
  REQUIRE(frames.front().place == 20);
  ++request.id;
  request.first = 26;
  REQUIRE_THAT(world.frame(request).error, Catch::Contains("first 26"));
}

TEST_CASE("what everyone watches keeps its time and leaves places out", "[render]") {
  test::RenderWorld world;
  (void)world.frame(world.request());
  auto request = along_a_path(world, 2, 25);
  request.client = 78;
  request.reply_port = 0;
  request.format = 0;
  world.paint_us = 100'000;
  const std::int64_t start = world.now.steady;
  (void)world.frame(request);
  const auto frames = world.frames_of(78);
  REQUIRE(frames.size() >= 15);
  REQUIRE(frames.size() <= 23);
  REQUIRE(frames.back().place == 50);
  REQUIRE(world.now.steady - start < 2'400'000);
}

TEST_CASE("a client that takes no frames gets no more, until it does", "[render]") {
  bool room = false;
  test::RenderWorld::Setting setting;
  setting.config.has_room = [&](std::int32_t, std::int64_t) { return room; };
  test::RenderWorld world(setting);
  world.ask(world.request());
  world.run(5'000'000);
  REQUIRE(world.frames.empty());
  room = true;
  world.run(1'000'000);
  REQUIRE(world.frames.size() == 1);
}

}  // namespace
}  // namespace voxatlas
