#include "integrate/free_rays.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/engine.hpp"
#include "unit/integrate/scan_oracle.hpp"

namespace voxatlas {
namespace {

constexpr int kPoints = 400'000;

/// Points as scanners give them: floats in a sensor's frame, moved to the Earth's surface.
std::vector<Eigen::Vector3d> points(std::mt19937_64& rng) {
  std::uniform_real_distribution<float> place(-60, 60);
  std::vector<Eigen::Vector3d> points(kPoints);
  for (auto& p : points) {
    p = Eigen::Vector3d(4.1e6, 6e5, 4.8e6) +
        Eigen::Vector3f(place(rng), place(rng), place(rng)).cast<double>();
  }
  return points;
}

/// Within five standard deviations of a share p of n.
void require_share(double count, double n, double p) {
  CAPTURE(count, n, p);
  REQUIRE(std::abs(count - n * p) < 5 * std::sqrt(n * p * (1 - p)));
}

TEST_CASE("one ray in 5/4 4^n frees, and which ones changes from scan to scan", "[integrate]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto ends = points(rng);
  const int coarser = GENERATE(0, 1, 2, 3, 4);
  const double share = 0.8 * std::pow(0.25, coarser);
  const std::int64_t utime = 1'433'152'800'000'000;
  const FreeRays now(utime, coarser), next(utime + 50'000, coarser);
  double in_now = 0, in_both = 0;
  for (const auto& end : ends) {
    in_now += now.has(end);
    in_both += now.has(end) && next.has(end);
  }
  if (coarser == 0) {
    REQUIRE(in_both == kPoints);
    return;
  }
  require_share(in_now, kPoints, share);
  require_share(in_both, kPoints, share * share);
}

TEST_CASE("points on a lattice, as coarse sensors give them, are chosen as evenly", "[integrate]") {
  const FreeRays rays(77, 3);
  for (int axis = 0; axis < 3; ++axis) {
    double chosen = 0;
    for (int i = 0; i < kPoints; ++i) {
      Eigen::Vector3d end(4.1e6, 6e5, 4.8e6);
      end[axis] += i * 0.002;
      chosen += rays.has(end);
    }
    require_share(chosen, kPoints, 1.0 / 80);
  }
}

TEST_CASE("the choice is the same on every machine", "[integrate]") {
  std::vector<int> chosen;
  const FreeRays rays(1'433'152'800'000'000, 3);
  for (int i = 0; i < 300; ++i) {
    if (rays.has({4'100'000 + 0.5 * i, -0.25 * i, 4.8e6})) chosen.push_back(i);
  }
  REQUIRE(chosen == std::vector<int>{11, 52, 156, 240, 271});  // Of a few lines of Python.
}

TEST_CASE("a scan's cells do not depend on the order of its points", "[integrate]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  Scan scan = test::ScanMaker{{4.1e6, 6e5, 4.8e6}, 20, 10, 2'000, false}(rng);
  scan.sigma = 0.02;
  Integrator integrator(Grid::standard(), IntegrationParameters{});
  const auto cells = test::cells_of(*integrator.integrate(scan));
  REQUIRE(cells.misses.size() > 20);
  std::shuffle(scan.endpoints_ecef.begin(), scan.endpoints_ecef.end(), rng);
  REQUIRE((test::cells_of(*integrator.integrate(scan)) == cells));
}

TEST_CASE("on average a voxel is missed about as often as rays pass it", "[integrate][oracle]") {
  // A wall of voxels 20 m away, rays through each in turn to a wall behind it: what coarse misses
  // take from the near wall, summed over many scans, against carving.
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> side(-4, 4);
  Integrator coarse(Grid::standard(), IntegrationParameters{});
  Integrator fine(Grid::standard(), IntegrationParameters{7, 7, 0, 120});
  double coarse_voxels = 0, fine_voxels = 0;
  for (int i = 0; i < 40; ++i) {
    Scan scan;
    scan.sigma = 0.02;
    scan.utime = i;
    for (int ray = 0; ray < 64; ++ray) {
      scan.endpoints_ecef.push_back({40, side(rng), side(rng)});
    }
    coarse_voxels +=
        512.0 * static_cast<double>(test::cells_of(*coarse.integrate(scan)).misses.size());
    fine_voxels += static_cast<double>(test::cells_of(*fine.integrate(scan)).misses.size());
  }
  // A ray passes some 1.3 cells an edge's length, at either size, so the sums agree but for the
  // fifth let off and for cells that several rays of a scan share near the origin, where carving
  // counts them once.
  CAPTURE(coarse_voxels, fine_voxels);
  REQUIRE(coarse_voxels > 0.65 * fine_voxels);
  REQUIRE(coarse_voxels < 1.2 * fine_voxels);
}

}  // namespace
}  // namespace voxatlas
