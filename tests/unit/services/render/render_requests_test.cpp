#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "base/utime.hpp"
#include "render_bench.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a bad request is answered by a frame that says what is bad", "[render]") {
  test::RenderBench bench;
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
  test::RenderBench bench;
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
  test::RenderBench bench;
  auto request = bench.request();
  request.deadline = utime_now() - 1;
  bench.service->on_request(request);
  REQUIRE_FALSE(bench.service->work().has_value());
  REQUIRE(bench.map.listed == 0);
  request.deadline = utime_now() + 60'000'000;
  REQUIRE(bench.frame(request).error.empty());
}

}  // namespace
}  // namespace voxatlas
