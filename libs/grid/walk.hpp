#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "grid/grid.hpp"

namespace voxatlas {

/// The cells a segment passes, from its origin's to its end's, both included, each once.
///
/// Source:  Amanatides and Woo 1987 (the paper's section 4.1).
/// Units:   voxels (Grid::to_voxels) for origin and end; the walk may go in cells of 2^shift
///          voxels, shift 0..7: cells then are voxel index >> shift.
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
  int step() {
    // The smallest t; x before y before z where they are equal.
    if (t_[0] <= t_[1]) return t_[0] <= t_[2] ? step_on<0>() : step_on<2>();
    return t_[1] <= t_[2] ? step_on<1>() : step_on<2>();
  }

 private:
  static constexpr double kLimit = 1 << 29;

  /// The axis is a constant, so that the compiler keeps the whole walk in registers.
  template <int axis>
  int step_on() {
    cell_[axis] += direction_[axis];
    border_[axis] += stride_[axis];  // Whole numbers below 2^30: exact.
    --left_[axis];
    --remaining_;
    aim(axis);
    return axis;
  }

  /// Looks at the next border of an axis; an axis that has made its steps has none.
  void aim(int axis) {
    t_[axis] = left_[axis] > 0 ? (border_[axis] - origin_[axis]) * inverse_[axis]
                               : std::numeric_limits<double>::infinity();
  }

  Eigen::Vector3d t_;        // Of the next border on each axis, 0 at the origin, 1 at the end.
  Eigen::Vector3d border_;   // That border, voxels.
  Eigen::Vector3d origin_;   // Voxels.
  Eigen::Vector3d inverse_;  // 1 / (end - origin); infinite, and never used, where they are equal.
  Eigen::Vector3d stride_;   // From border to border: +-2^shift.
  Eigen::Vector3i cell_;
  Eigen::Vector3i direction_;
  Eigen::Vector3i left_;  // Steps still to go on each axis.
  std::int64_t remaining_ = 0;
};

}  // namespace voxatlas
