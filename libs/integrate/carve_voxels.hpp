#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "integrate/marks.hpp"

namespace voxatlas {

/// Carves rays at depth 7 with vectors, eight slabs of a brick at a time.
///
/// Idea:   where a ray is on axis u when it crosses a border of its main axis is first estimated,
///         origin + t * (end - origin), rounded down, which is off by one border at most; the two
///         borders next to it then say exactly which cell it is, with Walk's own expression for
///         their t. No crossing waits for another one. The three cells of eight slabs are eight
///         words of the main axis' plane of a brick: they are marked by one OR.
/// Note:   Highway picks the best instructions at run time (AVX2, AVX-512); the marks are the same
///         on all of them, as nothing but the estimate may round differently.
/// Threads: one at a time; it keeps its buffers.
class VoxelCarver {
 public:
  /// Marks in `misses`, whose depth is 7, what Carver says. False where it could not: on processors
  /// without AVX2, or where rounding puts two borders into one slab; marks it may have set by then
  /// are right, but not all.
  bool carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
             Marks& misses);

 private:
  std::vector<std::int32_t> u_cells_, v_cells_;
};

}  // namespace voxatlas
