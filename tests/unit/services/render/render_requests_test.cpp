#include <algorithm>
#include <cmath>
#include <limits>

#include "render_world.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a bad request is answered by a frame that says what is bad", "[render]") {
  test::RenderWorld world;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::int64_t id = 100;
  const auto refused = [&](auto change, const std::string& word) {
    auto request = world.request();
    request.id = ++id;
    change(request);
    const frame_t frame = world.frame(request);
    CAPTURE(frame.error);
    REQUIRE_THAT(frame.error, Catch::Contains(word));
    REQUIRE(frame.data.empty());
    REQUIRE(frame.size == 0);
    REQUIRE(frame.final == 1);
  };
  using R = render_request_t;
  refused([&](R& r) { r.camera.position[1] = nan; }, "nan");
  refused([&](R& r) { r.camera.orientation[0] = nan; }, "nan");
  refused([](R& r) { std::fill_n(r.camera.orientation, 4, 0.0); }, "length 0");
  refused([](R& r) { r.camera.width = 0; }, "0 x 200");
  refused([](R& r) { r.camera.height = 100'000; }, "100000");
  refused([](R& r) { r.camera.near_range = 0; }, "near");
  refused([](R& r) { r.camera.projection = 2; }, "projection 2");
  refused([](R& r) { r.colouring = "plaid"; }, "plaid");
  refused([](R& r) { r.depth = 9; }, "depth 9");
  refused([](R& r) { r.depth = -1; }, "depth -1");
  refused([](R& r) { r.format = 7; }, "format 7");
  refused([](R& r) { r.depth_format = 3; }, "depth_format 3");
  refused([](R& r) { r.reply_port = 0; }, "reply_port is 0");
  refused([](R& r) { r.reply_port = 7; }, "reply_port");
  refused([](R& r) { r.kind = 3; }, "kind 3");
  refused([](R& r) { r.kind = 1; }, "rate of 0");
  refused([](R& r) { r.kind = 1, r.rate = 5; }, "deadline");
  refused([&](R& r) { r.kind = 1, r.rate = nan; }, "nan");
  refused([&](R& r) { r.budget_ms = nan; }, "nan");
  refused([](R& r) { r.budget_ms = -1; }, "-1");
  refused([](R& r) { r.backend = 9; }, "backend 9");
  refused([](R& r) { r.backend = 1, r.budget_ms = 5; }, "backend 1");
  refused([](R& r) { r.fill_holes = 2; }, "fill_holes 2");
  refused([](R& r) { r.overlay = 16; }, "overlay 16");
  refused([](R& r) { r.free_depth = 8; }, "free_depth 8");
  refused([](R& r) { r.path = Bytes(64), r.path_size = 64; }, "kind 0");
  refused([](R& r) { r.path = Bytes(64), r.path_size = 64, r.kind = 1, r.rate = 1; }, "row 0");
  refused([](R& r) { r.path = Bytes(7), r.path_size = 7, r.kind = 1, r.rate = 1; }, "7 bytes");
  REQUIRE(world.listed == 0);
  REQUIRE(world.frame(world.request()).error.empty());  // And goes on.
}

TEST_CASE("a thousand bad requests a second are not a thousand answers", "[render]") {
  test::RenderWorld world;
  auto request = world.broadcast();
  request.colouring = "plaid";
  for (int i = 0; i < 1000; ++i) {
    ++request.id;
    world.ask(request);
    world.run(1'000);
  }
  world.run(100'000);
  REQUIRE(world.frames.size() > 10);
  REQUIRE(world.frames.size() < 150);
  REQUIRE(world.frames.back().frame.id == request.id);
}

TEST_CASE("who asks a thousand times a second sees pictures, and delays no other", "[render]") {
  test::RenderWorld world;
  auto flood = world.broadcast();
  flood.budget_ms = GENERATE(0.0, 30.0);
  auto other = world.broadcast();
  other.client = 78;
  (void)world.frame(other);  // All tiles are there.
  std::int64_t asked_at = 0;
  std::size_t answered = 0;
  for (int i = 0; i < 2000; ++i) {
    ++flood.id;
    world.ask(flood);
    if (i % 100 == 0) {
      REQUIRE(world.frames_of(78).size() == answered + 1);  // Each was answered in its 100 ms.
      ++answered;
      ++other.id;
      asked_at = world.now.steady;
      world.ask(other);
    }
    world.run(1'000);
    if (world.frames.back().frame.client == 78) {
      REQUIRE(world.arrived_at.back() - asked_at <= 2 * 20'000 + 2'000 + 100'000);
    }
  }
  const auto floods = world.frames_of(77);
  REQUIRE(floods.size() > 30);  // The painter is shared, 20 ms a picture.
  REQUIRE(floods.back().id > flood.id - 60);
}

TEST_CASE("a client whose tiles do not come delays no other", "[render]") {
  test::RenderWorld world;
  auto other = world.request();
  other.client = 78;
  other.camera.position[0] += 50'000;  // Nothing there.
  (void)world.frame(other);
  const auto keys = world.in_view();
  world.silent.insert(keys.begin(), keys.end());
  world.ask(world.request());
  world.run(10'000);
  ++other.id;
  const std::int64_t asked = world.now.steady;
  (void)world.frame(other);
  REQUIRE(world.arrived_at.back() - asked < 100'000);
}

TEST_CASE("more clients than there is room for are told so", "[render]") {
  test::RenderWorld world;
  world.stores_answer = false;
  auto request = world.broadcast();
  for (request.client = 1; request.client <= 65; ++request.client) world.ask(request);
  world.run(20'000);
  REQUIRE(world.frames.size() == 1);
  REQUIRE(world.frames[0].frame.client == 65);
  REQUIRE_THAT(world.frames[0].frame.error, Catch::Contains("64"));
}

TEST_CASE("a request past its deadline is not drawn", "[render]") {
  test::RenderWorld world;
  auto request = world.request();
  request.deadline = world.now.utime - 1;
  world.ask(request);
  REQUIRE_FALSE(world.run(5'000'000, [&] { return !world.frames.empty(); }));
  REQUIRE(world.listed == 0);
  request.deadline = world.now.utime + 60'000'000;
  REQUIRE(world.frame(request).error.empty());
}

TEST_CASE("the same request again is no other; once answered, it is answered again", "[render]") {
  test::RenderWorld world;
  const auto request = world.request();
  world.ask(request);
  world.run(200, [] { return false; });
  world.ask(request);
  world.run(2'000'000);
  REQUIRE(world.frames.size() == 1);
  (void)world.frame(request);
  REQUIRE(world.frames.size() == 2);
}

TEST_CASE("a cancelled request gets no picture, even where one is being painted", "[render]") {
  test::RenderWorld world;
  (void)world.frame(world.request());
  auto request = world.request();
  ++request.id;
  world.ask(request);
  world.run(10'000);  // Half of the painting.
  request.kind = 2;
  world.ask(request);
  world.run(1'000'000);
  REQUIRE(world.frames.size() == 1);
  request.kind = 0;
  ++request.id;
  (void)world.frame(request);
}

TEST_CASE("a picture that is being painted goes out though a newer one is asked for", "[render]") {
  test::RenderWorld world;
  auto request = world.request();
  (void)world.frame(request);
  ++request.id;
  world.ask(request);
  world.run(10'000);
  ++request.id;
  (void)world.frame(request);
  const auto frames = world.frames_of(77);
  REQUIRE(frames.size() == 3);
  REQUIRE(frames[1].id == request.id - 1);
  REQUIRE(frames[2].id == request.id);
}

}  // namespace
}  // namespace voxatlas
