#include "grid/walk.hpp"

#include "base/check.hpp"

namespace voxatlas {

Walk::Walk(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, int shift)
    : origin_(origin_voxels) {
  VOX_CHECK(shift >= 0 && shift <= kDepth);
  for (int axis = 0; axis < 3; ++axis) {
    const double from = origin_voxels[axis];
    const double to = end_voxels[axis];
    VOX_CHECK(from >= 0 && from < kLimit && to >= 0 && to < kLimit);
    // Not negative, so cutting the fraction off is the floor.
    const int first = static_cast<int>(from) >> shift;
    const int last = static_cast<int>(to) >> shift;
    cell_[axis] = first;
    direction_[axis] = last < first ? -1 : 1;
    left_[axis] = last < first ? first - last : last - first;
    remaining_ += left_[axis];
    // The border below a cell bears the cell's number, the one above it the next.
    const int border = last < first ? first : first + 1;
    border_[axis] = static_cast<double>(static_cast<std::int64_t>(border) << shift);
    stride_[axis] = direction_[axis] * static_cast<double>(1 << shift);
    inverse_[axis] = 1 / (to - from);
    aim(axis);
  }
}

}  // namespace voxatlas
