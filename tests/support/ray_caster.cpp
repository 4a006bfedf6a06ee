#include "support/ray_caster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace voxatlas::test {

RayCaster::View::View(const Camera& camera, const Grid& grid)
    : eye(grid.to_voxels(camera.position())),
      near_z(camera.lens().near_range * grid.cells_per_metre()),
      far_z(camera.lens().far_range * grid.cells_per_metre()) {
  const Eigen::Matrix3d grid_from_camera = camera.rotation().transpose();
  const auto start = [&](double x, double y) -> Eigen::Vector3d {
    return grid_from_camera * camera.point(x, y, 0) * grid.cells_per_metre();
  };
  start_x = start(1, 0) - start(0, 0);
  start_y = start(0, 1) - start(0, 0);
  eye += start(0, 0);
  ray_0 = grid_from_camera * camera.ray(0, 0);
  ray_x = grid_from_camera * (camera.ray(1, 0) - camera.ray(0, 0));
  ray_y = grid_from_camera * (camera.ray(0, 1) - camera.ray(0, 0));
}

RayCaster::RayCaster(const Grid& grid, const std::map<TileKey, TileTree>& tiles, int depth)
    : grid_(grid),
      min_(VoxelIndex::Constant(std::numeric_limits<int>::max())),
      size_(VoxelIndex::Zero()) {
  VoxelIndex max = VoxelIndex::Zero();
  for (const auto& [key, tree] : tiles) {
    min_ = min_.cwiseMin(Grid::min_voxel(key));
    max = max.cwiseMax(VoxelIndex(Grid::min_voxel(key).array() + kTileVoxels));
  }
  if (tiles.empty()) min_ = max;
  size_ = max - min_;
  depths_.assign(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) *
                     static_cast<std::size_t>(size_.z()),
                 kNothing);
  for (const auto& [key, tree] : tiles) {
    const VoxelIndex corner = Grid::min_voxel(key);
    tree.for_each_cell(depth, [&](const Leaf& leaf) {
      if (!is_occupied(leaf.state.log_odds)) return;
      const Index3 min = leaf.cell.min_voxel();
      const auto edge = static_cast<int>(leaf.cell.edge_voxels());
      const VoxelIndex from =
          corner +
          VoxelIndex(static_cast<int>(min[0]), static_cast<int>(min[1]), static_cast<int>(min[2]));
      for (int z = 0; z < edge; ++z) {
        for (int y = 0; y < edge; ++y) {
          std::fill_n(
              depths_.begin() + static_cast<std::ptrdiff_t>(index(from + VoxelIndex(0, y, z))),
              edge, leaf.cell.depth);
        }
      }
    });
  }
}

std::optional<RayCaster::Sight> RayCaster::cast(const View& view, double x, double y) const {
  const Eigen::Vector3d ray = view.ray(x, y), eye = view.start(x, y);
  // Into the box, which the ray may enter late, and up to where it leaves it or ends.
  double z = view.near_z, end = view.far_z;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (min_[axis] - eye[axis]) / ray[axis];
    const double b = (min_[axis] + size_[axis] - eye[axis]) / ray[axis];
    z = std::max(z, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (!(z <= end)) return std::nullopt;
  VoxelIndex at;
  Eigen::Vector3i step, left;  // Which way on each axis, and how many voxels there are that way.
  Eigen::Vector3d next;        // Where the ray leaves the voxel, on each axis.
  std::array<std::ptrdiff_t, 3> stride{1, size_.x(), std::ptrdiff_t{size_.x()} * size_.y()};
  const Eigen::Vector3d inverse = ray.cwiseInverse();
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = ray[axis] < 0 ? -1 : 1;
    const int in_box = std::clamp(
        static_cast<int>(std::floor(eye[axis] + z * ray[axis])) - min_[axis], 0, size_[axis] - 1);
    at[axis] = min_[axis] + in_box;
    left[axis] = step[axis] > 0 ? size_[axis] - 1 - in_box : in_box;
    next[axis] = (at[axis] + (step[axis] > 0 ? 1 : 0) - eye[axis]) * inverse[axis];
    stride[static_cast<std::size_t>(axis)] *= step[axis];
  }
  const std::uint8_t* depth = depths_.data() + index(at);
  while (*depth == kNothing) {
    int axis = next[0] < next[1] ? 0 : 1;
    if (next[2] < next[axis]) axis = 2;
    z = std::max(z, next[axis]);
    if (z > end || left[axis]-- == 0) return std::nullopt;
    at[axis] += step[axis];
    depth += stride[static_cast<std::size_t>(axis)];
    next[axis] = (at[axis] + (step[axis] > 0 ? 1 : 0) - eye[axis]) * inverse[axis];
  }
  return Sight{grid_.tile_of(at), CellKey::of_voxel(Grid::in_tile(at), *depth),
               z / grid_.cells_per_metre()};
}

/// The nearest that the ray o + t d comes to the edge that starts at p along an axis.
static double distance_to_edge(const Eigen::Vector3d& d, const Eigen::Vector3d& p, int axis,
                               double length) {
  // Across the axis the edge is a point; where it is nearest may lie past an end.
  double nearest = std::numeric_limits<double>::infinity();
  const auto to_point = [&](const Eigen::Vector3d& q) {
    const double t = q.dot(d) / d.squaredNorm();
    return (q - t * d).norm();
  };
  const Eigen::Vector3d along = Eigen::Vector3d::Unit(axis);
  const Eigen::Vector3d across = d.cross(along);
  nearest = std::min(to_point(p), to_point(p + length * along));
  if (across.norm() < 1e-12 * d.norm()) return nearest;
  // The lines' nearest points: p + s along, with (p + s along - t d) normal to both.
  const Eigen::Vector3d flat = d - d.dot(along) * along;
  const double t = (p - p.dot(along) * along).dot(flat) / flat.squaredNorm();
  const double s = (t * d - p).dot(along);
  if (s >= 0 && s <= length) nearest = std::min(nearest, std::abs(p.dot(across)) / across.norm());
  return nearest;
}

double RayCaster::edge_distance(const View& view, double x, double y, TileKey tile,
                                CellKey cell) const {
  const Eigen::Vector3d ray = view.ray(x, y), eye = view.start(x, y);
  const Index3 min = cell.min_voxel();
  const double length = cell.edge_voxels();
  const Eigen::Vector3d corner =
      (Grid::min_voxel(tile) +
       VoxelIndex(static_cast<int>(min[0]), static_cast<int>(min[1]), static_cast<int>(min[2])))
          .cast<double>() -
      eye;
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 4; ++side) {
      Eigen::Vector3d from = corner;
      from[(axis + 1) % 3] += side % 2 * length;
      from[(axis + 2) % 3] += side / 2 * length;
      nearest = std::min(nearest, distance_to_edge(ray, from, axis, length));
    }
    for (const double face : {corner[axis], corner[axis] + length}) {
      for (const double plane : {view.near_z, view.far_z}) {
        nearest = std::min(nearest, std::abs(face - plane * ray[axis]));
      }
    }
  }
  return nearest / grid_.cells_per_metre();
}

}  // namespace voxatlas::test
