#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>

#include "integrate/integrator.hpp"

namespace voxatlas::test {

/// A cell of a known depth over the whole grid: voxel index >> (7 - depth).
using GlobalCell = std::array<std::int64_t, 3>;

/// What one scan changes, as plain sets.
struct ScanCells {
  int miss_depth = 0, hit_depth = 0;
  std::set<GlobalCell> misses, hits;
  std::map<GlobalCell, std::array<int, 3>> colours;
  std::uint64_t rays_hit = 0, beyond_max = 0, below_min = 0, not_finite = 0, off_cube = 0;

  friend bool operator==(const ScanCells&, const ScanCells&) = default;
};

/// Oracle: every border crossing of every ray listed and sorted, every rule applied to sets.
ScanCells cells_by_sorting(const Scan& scan, const IntegrationParameters& parameters, int k);

/// An integrator's answer in the same form; fails the test where a delta breaks its layout.
ScanCells cells_of(const ScanDelta& delta);

/// Rays around a place, half of the points on cell borders, all three axes at once or one alone.
struct ScanMaker {
  Eigen::Vector3d place_ecef;
  double reach;  ///< Metres, on each axis.
  int k;
  std::size_t rays;
  bool coloured;

  Scan operator()(std::mt19937_64& rng) const;
};

}  // namespace voxatlas::test
