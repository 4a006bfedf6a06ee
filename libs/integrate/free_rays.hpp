#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>

namespace voxatlas {

/// Which rays of a scan free the cells they pass, where those are coarser than the cells of hits.
///
/// Rule:    a ray is about as wide as a hit's cell, and a cell 2^n times as wide has room for 4^n
///          such rays side by side: one ray says nothing of most of it. Were one ray in 4^n let
///          through, a voxel would be missed as often, on average, as if rays were carved at the
///          hits' depth, whatever the scanner and the distance. It is one in 5/4 4^n, 80 where free
///          space is at 80 cm and hits at 10, as thin things ask for a little more (README).
/// Choice:  by a hash of the scan's time and the endpoint's bits, all of them: not by the order of
///          the points, and not the same rays in the next scan of a scanner that stands still.
/// Result:  the same on every machine.
class FreeRays {
 public:
  /// `coarser`: n, 0..7; 0 lets every ray through.
  FreeRays(std::int64_t utime, int coarser)
      : seed_(static_cast<std::uint64_t>(utime)),
        below_(coarser == 0 ? 0 : ~std::uint64_t{0} / (5ull << 2 * (coarser - 1))) {}

  bool has(const Eigen::Vector3d& endpoint_ecef) const {
    if (below_ == 0) return true;
    std::uint64_t hash = seed_;
    for (int axis = 0; axis < 3; ++axis) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(endpoint_ecef[axis])) * kOdd;
      hash ^= hash >> 32;
    }
    return hash * kOdd < below_;
  }

 private:
  static constexpr std::uint64_t kOdd = 0x9e37'79b9'7f4a'7c15;  ///< 2^64 over the golden ratio.

  std::uint64_t seed_;
  std::uint64_t below_;  ///< So low a hash is let through; 0: every one is.
};

}  // namespace voxatlas
