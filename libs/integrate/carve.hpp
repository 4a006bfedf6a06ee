#pragma once

#include <Eigen/Core>

#include "integrate/marks.hpp"

namespace voxatlas {

/// Marks every cell that a ray passes, from its origin's to the one before its end's.
///
/// Source: the paper's section 4.1. The cells are those of grid/walk.hpp's Walk, one for one;
///         carve_steps() finds them many at a time, and Walk itself marks what that refuses.
/// Units:  cells of `misses`, whose depth is 7: voxels as Walk takes them. For coarser cells both
///         points are scaled by a power of two, which rounds nothing, and so is Walk.
/// Result: marks in every plane: Marks::merge() before they are read.
void carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, Marks& misses);

}  // namespace voxatlas
