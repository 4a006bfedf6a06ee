#include <algorithm>
#include <cmath>
#include <utility>

#include "render/cell_image.hpp"
#include "render/splat_kernels.hpp"

namespace voxatlas {
namespace {

/// The longest way to anything that is seen, as a multiple of the far range.
double longest_way(const Camera& camera) {
  const double far_range = camera.lens().far_range;
  double longest = 1;
  for (const double x : {0, camera.width()}) {
    for (const double y : {0, camera.height()}) {
      longest = std::max(longest, camera.point(x, y, far_range).norm() / far_range);
    }
  }
  return longest;
}

SplatFrame::Level level_of(int depth, const Eigen::Matrix3d& project, const Eigen::Vector2d& offset,
                           const Eigen::Vector3d& in_voxel) {
  SplatFrame::Level level;
  const double edge = 1 << (kDepth - depth);
  level.half = static_cast<float>(edge / 2);
  level.reach_z = static_cast<float>(project.row(2).cwiseAbs().sum() * edge / 2);
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d corner(octant & 1, octant >> 1 & 1, octant >> 2);
    const Eigen::Vector3d p = project * ((corner.array() + 0.5).matrix() * edge - in_voxel);
    level.x[octant] = static_cast<float>(p.x() + offset.x());
    level.y[octant] = static_cast<float>(p.y() + offset.y());
    level.z[octant] = static_cast<float>(p.z());
  }
  return level;
}

}  // namespace

/// Rounding: a cell's middle is a sum of a few floats, each right to 2^-24 of the terms, which are
/// at most as long as the way to it times a focal length; so a projection is off by some 1e-6 of
/// (focal length + picture) * way / z, and way / z is at most twice the longest ray of the picture
/// for a cell that touches it. A map's is off by 1e-6 of (pixels a voxel * way + picture). Rects
/// are widened by that; who is drawn, the slabs say.
SplatFrame::SplatFrame(const Camera& camera, const Grid& grid)
    : width(camera.width()),
      height(camera.height()),
      map(camera.orthographic()),
      eye(grid.voxel_unchecked(camera.position())) {
  const Lens& lens = camera.lens();
  const Eigen::Vector3d within = grid.to_voxels(camera.position()) - eye.cast<double>();
  const Eigen::Matrix3d rotation = camera.rotation();
  const double voxels = grid.cells_per_metre();
  Eigen::Matrix3d intrinsic = Eigen::Matrix3d::Identity();
  Eigen::Vector2d moved(lens.cx, lens.cy);
  if (map) {
    intrinsic.diagonal() << lens.fx / voxels, lens.fy / voxels, 1;
  } else {
    intrinsic << lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1;
    moved.setZero();
  }
  offset = {static_cast<float>(moved.x()), static_cast<float>(moved.y())};
  const Eigen::Matrix3d projection = intrinsic * rotation;
  const auto plane = [&](auto& at_0, auto& dx, auto& dy, auto&& of) {
    const Eigen::Matrix3d back = rotation.transpose();
    Eigen::Vector3d::Map(at_0.data()) = back * of(0, 0);
    Eigen::Vector3d::Map(dx.data()) = back * (of(1, 0) - of(0, 0));
    Eigen::Vector3d::Map(dy.data()) = back * (of(0, 1) - of(0, 0));
  };
  plane(ray, ray_dx, ray_dy, [&](double x, double y) { return camera.ray(x, y); });
  plane(start, start_dx, start_dy,
        [&](double x, double y) { return Eigen::Vector3d(voxels * camera.point(x, y, 0)); });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    in_voxel[axis] = static_cast<float>(within[i]);
    const auto all_rays = static_cast<float>(ray[axis]);
    map_inverse[axis] =
        1 / (std::abs(all_rays) < kTinyRay ? std::copysign(kTinyRay, all_rays) : all_rays);
    for (std::size_t row = 0; row < 3; ++row) {
      project[row][axis] = static_cast<float>(projection(static_cast<Eigen::Index>(row), i));
    }
  }
  for (int depth = 0; depth <= kDepth; ++depth) {
    levels[static_cast<std::size_t>(depth)] = level_of(depth, projection, moved, within);
  }
  near_z = static_cast<float>(lens.near_range * voxels);
  far_z = static_cast<float>(lens.far_range * voxels);
  const double way = longest_way(camera);
  const double focal = (lens.fx + lens.fy) * (map ? lens.far_range : 1);
  const double pixels = focal + std::abs(lens.cx) + lens.width + std::abs(lens.cy) + lens.height;
  slack_pixels = static_cast<float>(0.01 + 1e-6 * pixels * (1 + way));
  slack_z = static_cast<float>(0.01 + 1e-5 * way * far_z);
  steepest = map ? 0 : static_cast<float>(2e-4 * (1 + way));
  voxel_metres = static_cast<float>(1 / voxels);
}

/// Corners are projected one by one, so the slack is that of a corner up to 8 times nearer than the
/// farthest: 24 times that of a middle.
PixelRect SplatFrame::tightened(const std::array<std::int32_t, 3>& corner, int edge,
                                const PixelRect& rect, int x0) const {
  std::array<std::array<float, 8>, 3> p;  // Homogeneous pixels of the corners.
  for (std::size_t row = 0; row < 3; ++row) {
    for (unsigned octant = 0; octant < 8; ++octant) {
      float sum = row < 2 ? offset[row] : 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int face = corner[axis] + ((octant >> axis & 1u) != 0 ? edge : 0);
        sum += project[row][axis] * (static_cast<float>(face) - in_voxel[axis]);
      }
      p[row][octant] = sum;
    }
  }
  if (map) p[2].fill(1);
  const auto [nearest, farthest] = std::minmax_element(p[2].begin(), p[2].end());
  if (!(*nearest > 0.25f && *nearest * 8 > *farthest)) return rect;
  const auto limits = [&](std::size_t row) {
    for (std::size_t i = 0; i < 8; ++i) p[row][i] /= p[2][i];
    const auto [low, high] = std::minmax_element(p[row].begin(), p[row].end());
    const float widest = 20'000, slack = slack_pixels * 24;
    return std::pair(static_cast<int>(std::clamp(*low - slack, -widest, widest) - 1),
                     static_cast<int>(std::clamp(*high + slack, -widest, widest) + 1));
  };
  const auto [xa, xb] = limits(0);
  const auto [ya, yb] = limits(1);
  return {std::max(rect.xa, xa - x0), std::max(rect.ya, ya), std::min(rect.xb, xb - x0),
          std::min(rect.yb, yb)};
}

void SplatStrip::reset(const SplatFrame& frame, int first_column, int columns) {
  x0 = first_column;
  width = columns;
  coverage.reset(columns, frame.height);
  const auto bands = static_cast<std::size_t>((frame.height + kBand - 1) / kBand);
  rows.resize(std::max(rows.size(), bands * kBand));
  begun.assign(bands, 0);
}

}  // namespace voxatlas
