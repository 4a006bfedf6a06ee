#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "grid/grid.hpp"
#include "octree/tile_tree.hpp"
#include "render/camera.hpp"

namespace voxatlas::test {

/// The oracle of pictures: a ray steps from voxel to voxel, in double, through a plain array of
/// all voxels, until one is occupied.
///
/// Memory: a byte a voxel of the box around the tiles.
class RayCaster {
 public:
  /// Cells as they are drawn at `depth`: leaves above it, and whatever is occupied at it.
  RayCaster(const Grid& grid, const std::map<TileKey, TileTree>& tiles, int depth);

  /// Which cell, and where the ray enters it, metres along the camera's axis.
  struct Sight {
    TileKey tile;
    CellKey cell;
    double z;
  };

  /// A camera, ready for many rays.
  struct View {
    View(const Camera& camera, const Grid& grid);
    /// Voxels along each axis for a voxel along the camera's axis, at a place of the picture.
    Eigen::Vector3d ray(double x, double y) const { return ray_0 + x * ray_x + y * ray_y; }
    /// Where that ray has z = 0: the eye, but for orthographic cameras; voxels.
    Eigen::Vector3d start(double x, double y) const { return eye + x * start_x + y * start_y; }

    Eigen::Vector3d eye;  ///< Of place (0, 0); voxels, as Grid::to_voxels.
    Eigen::Vector3d start_x, start_y;
    Eigen::Vector3d ray_0, ray_x, ray_y;
    double near_z, far_z;  ///< Voxels.
  };
  std::optional<Sight> cast(const View& view, double x, double y) const;

  /// How near the ray through a place of the picture passes an edge of a cell, metres; for cells
  /// that the near or the far plane cuts the cut counts as one.
  double edge_distance(const View& view, double x, double y, TileKey tile, CellKey cell) const;

 private:
  static constexpr std::uint8_t kNothing = 0xff;

  std::size_t index(const VoxelIndex& voxel) const {
    const Eigen::Vector3i at = voxel - min_;
    return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(at.y())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(at.x());
  }

  Grid grid_;
  VoxelIndex min_, size_;
  std::vector<std::uint8_t> depths_;  // Of each voxel's cell, or kNothing.
};

}  // namespace voxatlas::test
