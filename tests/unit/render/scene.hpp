#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "geodesy/enu_frame.hpp"
#include "grid/grid.hpp"
#include "octree/tile_tree.hpp"
#include "render/camera.hpp"
#include "render/cell_cloud.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas::test {

/// A model in memory, built voxel by voxel in a local frame at the TUM city campus in Munich, where
/// the grid's axes are tilted against the ground.
class Scene {
 public:
  Scene();

  const Grid& grid() const { return grid_; }
  const EnuFrame& frame() const { return frame_; }
  const std::map<TileKey, TileTree>& tiles() const { return tiles_; }

  void occupy(const Eigen::Vector3d& p_enu, std::optional<Rgb> rgb = std::nullopt);
  /// Every voxel that a box in `frame` touches at one of its points, sampled every 4 cm.
  void occupy_box(const Eigen::Vector3d& min_enu, const Eigen::Vector3d& max_enu,
                  std::optional<Rgb> rgb = std::nullopt);

  std::vector<TileKey> keys() const;
  std::vector<TileWeight> weights() const;

  Result<Camera> camera(const Eigen::Vector3d& eye_enu, const Eigen::Vector3d& target_enu,
                        const Lens& lens) const;

 private:
  Grid grid_ = Grid::standard();
  EnuFrame frame_;
  std::map<TileKey, TileTree> tiles_;
};

/// The clouds of some tiles at a depth; owns them.
class Clouds {
 public:
  Clouds(const Scene& scene, int depth);
  const std::vector<PlacedCloud>& placed() const { return placed_; }

 private:
  std::vector<CellCloud> clouds_;
  std::vector<PlacedCloud> placed_;
};

/// A street 80 m long: ground, facades on both sides, a car.
Scene street_scene();

}  // namespace voxatlas::test
