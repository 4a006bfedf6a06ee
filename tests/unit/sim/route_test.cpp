#include "sim/route.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <utility>

#include "sim/ground.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a route goes on without a jump, forward, and stays on the road", "[sim][oracle]") {
  const double step = 0.25;
  const Route route(1, 14'000);
  Route::Place last = route.at(0);
  for (double s = step; s <= 14'000; s += step) {
    const Route::Place place = route.at(s);
    CAPTURE(s);
    const Eigen::Vector2d moved = place.p - last.p;
    REQUIRE(moved.norm() <= step + 1e-9);
    REQUIRE(moved.norm() > 0.99 * step);
    const Eigen::Vector2d forward(std::cos(last.heading), std::sin(last.heading));
    REQUIRE(moved.dot(forward) > 0.99 * step);
    REQUIRE_FALSE(Ground::on_block(place.p.x(), place.p.y()));
    last = place;
  }
}

TEST_CASE("a long route comes through every street", "[sim]") {
  const Route route(1, 14'000);
  std::set<std::pair<long, long>> streets;  // By the middle between two crossings, half pitches.
  for (double s = 0; s <= 14'000; s += 2) {
    const Eigen::Vector2d at = route.at(s).p / Ground::kPitch * 2;
    const auto x = std::lround(at.x()), y = std::lround(at.y());
    if ((x + y) % 2 != 0) streets.insert({x, y});
  }
  REQUIRE(streets.size() == 84);  // 2 x 7 streets of 6 parts.
}

TEST_CASE("a longer route begins as the shorter one does", "[sim]") {
  const Route brief(7, 300), lengthy(7, 30'000);
  for (double s = 0; s <= 300; s += 1) REQUIRE(brief.at(s).p == lengthy.at(s).p);
}

}  // namespace
}  // namespace voxatlas
