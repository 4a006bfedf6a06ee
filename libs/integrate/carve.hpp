#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "integrate/carve_voxels.hpp"
#include "integrate/marks.hpp"

namespace voxatlas {

/// The borders of one axis that a ray crosses. times[i] is the t of the i-th; after the last come
/// two infinities.
struct CarvedAxis {
  int first_cell = 0;
  int direction = 1;
  std::uint32_t crossings = 0;
  std::vector<double> times;

  void aim(double origin, double end, int shift);
};

/// Marks every cell that a ray passes, from its origin's to the one before its end's.
///
/// Source: the paper's section 4.1. The cells are those of grid/walk.hpp's Walk, one for one, with
///         its very expression for a border's t; only the way to them differs.
/// Idea:   the borders of one axis are crossed in order, so where a ray is depends on nothing but
///         how many borders of each axis lie before a t. The axis with the most crossings cuts the
///         ray into slabs; within a slab the other two axes are crossed at most once each (rounding
///         can make it twice: that is handled, slowly), so a slab has three cells, of which some
///         may be equal, and marking a cell twice changes nothing: no branch depends on the ray.
/// Units:  voxels, as Walk takes them.
/// Note:   this is the inner part that a vectorised one replaces: nothing else knows how a ray
///         finds its cells.
class Carver {
 public:
  /// Leaves marks in every plane: Marks::merge() before they are read.
  void carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
             Marks& misses);

 private:
  std::array<CarvedAxis, 3> axes_;
  VoxelCarver voxels_;
};

}  // namespace voxatlas
