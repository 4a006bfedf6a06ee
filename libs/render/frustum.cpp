#include "render/frustum.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace voxatlas {
namespace {

/// Rounding in the planes: a box that only touches one counts as seen. Metres.
constexpr double kSlack = 1e-6;

/// The corner of `box` farthest along `normal`.
Eigen::Vector3d farthest_corner(const Box& box, const Eigen::Vector3d& normal) {
  return (normal.array() >= 0).select(box.max, box.min);
}

}  // namespace

Frustum::Frustum(const Camera& camera) : position_(camera.position()) {
  const Lens& lens = camera.lens();
  const Eigen::Matrix3d ecef_from_camera = camera.rotation().transpose();
  // x between these and y between those, times z where all rays meet in the camera.
  const double left = -lens.cx / lens.fx, right = (lens.width - lens.cx) / lens.fx;
  const double top = -lens.cy / lens.fy, bottom = (lens.height - lens.cy) / lens.fy;
  const double per_z = camera.orthographic() ? 0 : 1, fixed = 1 - per_z;
  const std::array<Eigen::Vector4d, 6> inside = {
      Eigen::Vector4d{1, 0, -per_z * left, -fixed * left},
      Eigen::Vector4d{-1, 0, per_z * right, fixed * right},
      Eigen::Vector4d{0, 1, -per_z * top, -fixed * top},
      Eigen::Vector4d{0, -1, per_z * bottom, fixed * bottom},
      Eigen::Vector4d{0, 0, 1, -lens.near_range},
      Eigen::Vector4d{0, 0, -1, lens.far_range}};
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    const Eigen::Vector4d plane = inside[i] / inside[i].head<3>().norm();
    planes_[i] = {ecef_from_camera * plane.head<3>(), plane[3]};
  }
}

bool Frustum::may_see(const Box& box) const {
  const Box relative{box.min - position_, box.max - position_};
  return std::all_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
    return plane.normal.dot(farthest_corner(relative, plane.normal)) + plane.offset >= -kSlack;
  });
}

TileRange tiles_of(const Grid& grid, const Box& box) {
  const double last = grid.tiles_per_axis() - 1.0;
  const auto index = [&](double x) {
    const double tile = std::floor(x / grid.tile_length()) + grid.tiles_per_axis() / 2.0;
    return static_cast<std::uint32_t>(std::clamp(tile, 0.0, last));
  };
  // Dividing may misplace a border by one tile; a range may hold a tile too many, never one less.
  constexpr double kMargin = 1e-3;
  TileRange range;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    range.min[i] = index(box.min[axis] - kMargin);
    range.max[i] = index(box.max[axis] + kMargin);
  }
  return range;
}

double distance(const Box& box, const Eigen::Vector3d& p_ecef) {
  return (p_ecef.cwiseMax(box.min).cwiseMin(box.max) - p_ecef).norm();
}

std::vector<TileKey> tiles_in_view(const Camera& camera, const Grid& grid,
                                   std::span<const TileKey> keys) {
  const Frustum frustum(camera);
  std::vector<std::pair<double, TileKey>> seen;
  for (const TileKey key : keys) {
    const Box box = grid.box(key);
    if (frustum.may_see(box)) seen.emplace_back(distance(box, camera.position()), key);
  }
  std::sort(seen.begin(), seen.end());
  std::vector<TileKey> nearest_first;
  nearest_first.reserve(seen.size());
  for (const auto& [metres, key] : seen) nearest_first.push_back(key);
  return nearest_first;
}

}  // namespace voxatlas
