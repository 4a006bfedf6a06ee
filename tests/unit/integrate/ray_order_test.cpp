#include "integrate/ray_order.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Ends = std::vector<Eigen::Vector3d>;

bool before(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

/// As a scanner's 16 beams come: one above the other, then the next direction of turning.
Ends turning(const Eigen::Vector3d& origin, std::mt19937_64& rng) {
  std::uniform_real_distribution<double> range(1, 120);
  Ends ends;
  for (int turn = 0; turn < 3600; ++turn) {
    const double azimuth = turn * 0.1 * M_PI / 180;
    for (int beam = -8; beam < 8; ++beam) {
      const double up = beam * 2 * M_PI / 180;
      ends.push_back(origin + range(rng) * Eigen::Vector3d(std::cos(up) * std::cos(azimuth),
                                                           std::cos(up) * std::sin(azimuth),
                                                           std::sin(up)));
    }
  }
  return ends;
}

/// Radians from each ray to the next, on average.
double mean_turn(const Eigen::Vector3d& origin, const Ends& ends) {
  double sum = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double cosine = (ends[i - 1] - origin).normalized().dot((ends[i] - origin).normalized());
    sum += std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return sum / static_cast<double>(ends.size() - 1);
}

TEST_CASE("rays side by side follow one another, and none is lost", "[integrate]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Eigen::Vector3d origin(1000.5, -2000.25, 3000.125);
  const Ends came = turning(origin, rng);
  Ends sorted = came;
  RayOrder order;
  order.sort(origin, sorted);
  // A square is some 3 degrees wide: in it a ray is 1.5 degrees from the next, not 2 to 30.
  REQUIRE(mean_turn(origin, came) > 3.5 * M_PI / 180);
  REQUIRE(mean_turn(origin, sorted) < 2 * M_PI / 180);
  Ends again = came;
  order.sort(origin, again);  // With buffers that are in use.
  REQUIRE(again == sorted);

  Ends all = came;
  std::sort(all.begin(), all.end(), before);
  std::sort(sorted.begin(), sorted.end(), before);
  REQUIRE(all == sorted);
}

TEST_CASE("rays on axes, on diagonals and without length have a place in the order",
          "[integrate]") {
  const Eigen::Vector3d origin(7, 7, 7);
  Ends ends;
  for (int i = 0; i < 27; ++i) {
    ends.push_back(origin + Eigen::Vector3d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
  }
  Ends sorted = ends;
  RayOrder order;
  order.sort(origin, sorted);
  std::sort(ends.begin(), ends.end(), before);
  std::sort(sorted.begin(), sorted.end(), before);
  REQUIRE(sorted == ends);
  Ends none;
  order.sort(origin, none);
  REQUIRE(none.empty());
}

}  // namespace
}  // namespace voxatlas
