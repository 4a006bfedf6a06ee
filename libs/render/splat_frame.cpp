#include <algorithm>
#include <cmath>

#include "render/cell_image.hpp"
#include "render/splat_kernels.hpp"

namespace voxatlas {
namespace {

/// The longest ray of the picture, scaled to z = 1.
double longest_ray(const Camera& camera) {
  double longest = 1;
  for (const double x : {0, camera.width()}) {
    for (const double y : {0, camera.height()}) {
      longest = std::max(longest, camera.ray(x, y).norm());
    }
  }
  return longest;
}

SplatFrame::Level level_of(int depth, const Eigen::Matrix3d& project,
                           const Eigen::Vector3d& in_voxel) {
  SplatFrame::Level level;
  const double edge = 1 << (kDepth - depth);
  level.half = static_cast<float>(edge / 2);
  level.reach_z = static_cast<float>(project.row(2).cwiseAbs().sum() * edge / 2);
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d corner(octant & 1, octant >> 1 & 1, octant >> 2);
    const Eigen::Vector3d p = project * ((corner.array() + 0.5).matrix() * edge - in_voxel);
    level.x[octant] = static_cast<float>(p.x());
    level.y[octant] = static_cast<float>(p.y());
    level.z[octant] = static_cast<float>(p.z());
  }
  return level;
}

}  // namespace

/// Rounding: a cell's middle is a sum of a few floats, each right to 2^-24 of the terms, which are
/// at most as long as the way to it times a focal length; so a projection is off by some 1e-6 of
/// (focal length + picture) * way / z, and way / z is at most twice the longest ray of the picture
/// for a cell that touches it. Rects are widened by that; who is drawn, the slabs say.
SplatFrame::SplatFrame(const Camera& camera, const Grid& grid)
    : width(camera.width()), height(camera.height()), eye(grid.voxel_unchecked(camera.position())) {
  const Lens& lens = camera.lens();
  const Eigen::Vector3d within = grid.to_voxels(camera.position()) - eye.cast<double>();
  const Eigen::Matrix3d rotation = camera.rotation();
  Eigen::Matrix3d intrinsic;
  intrinsic << lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1;
  const Eigen::Matrix3d projection = intrinsic * rotation;
  const Eigen::Vector3d ray_x = rotation.row(0).transpose() / lens.fx;
  const Eigen::Vector3d ray_y = rotation.row(1).transpose() / lens.fy;
  const Eigen::Vector3d ray_0 = rotation.row(2).transpose() - lens.cx * ray_x - lens.cy * ray_y;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    in_voxel[axis] = static_cast<float>(within[i]);
    ray[axis] = ray_0[i];
    ray_dx[axis] = ray_x[i];
    ray_dy[axis] = ray_y[i];
    for (std::size_t row = 0; row < 3; ++row) {
      project[row][axis] = static_cast<float>(projection(static_cast<Eigen::Index>(row), i));
    }
  }
  for (int depth = 0; depth <= kDepth; ++depth) {
    levels[static_cast<std::size_t>(depth)] = level_of(depth, projection, within);
  }
  near_z = static_cast<float>(lens.near_range * grid.cells_per_metre());
  far_z = static_cast<float>(lens.far_range * grid.cells_per_metre());
  const double longest = longest_ray(camera);
  const double pixels =
      lens.fx + std::abs(lens.cx) + lens.width + lens.fy + std::abs(lens.cy) + lens.height;
  slack_pixels = static_cast<float>(0.01 + 1e-6 * pixels * (1 + longest));
  slack_z = static_cast<float>(0.01 + 1e-5 * longest * far_z);
  steepest = static_cast<float>(2e-4 * (1 + longest));
  voxel_metres = static_cast<float>(1.0 / grid.cells_per_metre());
}

void SplatStrip::reset(const SplatFrame& frame, int first_column, int columns) {
  x0 = first_column;
  width = columns;
  coverage.reset(columns, frame.height);
  const std::size_t count = coverage.block_index(0, coverage.blocks_y()) * 64;
  for (auto& axis : inverse) axis.resize(count);
  cell.assign(count, CellImage::kNone);
  z.assign(count, CellImage::kNowhere);
}

}  // namespace voxatlas
