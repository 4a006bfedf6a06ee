#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>

#include "grid/grid.hpp"

namespace voxatlas {

/// The cells a segment passes, from its origin's to its end's, both included, each once.
///
/// Source:  Amanatides and Woo 1987 (the paper's sections 4.1).
/// Units:   voxels (metres times cells per metre, plus half_voxels) for origin and end; the walk
/// may
///          go in cells of 2^shift voxels, shift 0..7: cells then are voxel index >> shift.
/// Borders: a cell owns its lower faces. The walk takes exactly |cell(end) - cell(origin)| steps on
///          each axis, so that it always ends in the end's cell; each step is on the axis whose
///          next border has the smallest t = (border - origin) / (end - origin), ties x before y
///          before z. t is computed anew from the border at each step, in double, never
///          accumulated: so a walk in coarse cells visits exactly the parents of the fine walk's
///          cells, and a ray cut at tile borders visits the same cells as the whole.
/// Errors:  none: both ends must lie on the grid (finite, 0 <= v < 2^29).
/// Cost:    one division an axis at the start, one multiplication a step.
class Walk {
 public:
  Walk(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, int shift);

  /// The current cell, and the number of steps still to go.
  const Eigen::Vector3i& cell() const { return cell_; }
  std::int64_t remaining() const { return remaining_; }

  /// Steps to the next cell; remaining() must be positive. Returns the axis stepped on.
  int step();
};

}  // namespace voxatlas
