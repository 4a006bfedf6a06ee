#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>

namespace voxatlas {

/// Which rays of a scan free the cells they pass, where those are coarser than the cells of hits.
///
/// Rule:    a ray is about as wide as a hit's cell, and a cell 2^n times as wide has room for 4^n
///          such rays side by side: one ray says nothing of most of it. So one ray in 4^n is let
///          through: as many rays miss a voxel as at the hits' depth would have passed it, on
///          average, whatever the scanner and the distance.
/// Choice:  by a hash of the scan's time and the endpoint's bits, all of them: not by the order of
///          the points, and not the same rays in the next scan of a scanner that stands still.
/// Result:  the same on every machine.
class FreeRays {
 public:
  /// `coarser`: n, 0..7; 0 lets every ray through.
  FreeRays(std::int64_t utime, int coarser)
      : seed_(static_cast<std::uint64_t>(utime)), coarser_(coarser) {}

  bool has(const Eigen::Vector3d& endpoint_ecef) const {
    if (coarser_ == 0) return true;
    std::uint64_t hash = seed_;
    for (int axis = 0; axis < 3; ++axis) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(endpoint_ecef[axis])) * kOdd;
      hash ^= hash >> 32;
    }
    return hash * kOdd >> (64 - 2 * coarser_) == 0;
  }

 private:
  static constexpr std::uint64_t kOdd = 0x9e37'79b9'7f4a'7c15;  ///< 2^64 over the golden ratio.

  std::uint64_t seed_;
  int coarser_;
};

}  // namespace voxatlas
