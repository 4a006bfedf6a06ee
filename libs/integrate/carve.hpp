#pragma once

#include <Eigen/Core>

#include "integrate/marks.hpp"

namespace voxatlas {

/// Marks every cell that a ray passes, from its origin's to the one before its end's.
///
/// Source: the paper's section 4.1; grid/walk.hpp says which cells those are.
/// Units:  voxels, as Walk takes them.
/// Note:   this is the inner part that a vectorised walk replaces: nothing else knows how a ray
///         finds its cells.
void carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, Marks& misses);

}  // namespace voxatlas
