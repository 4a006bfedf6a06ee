#include "scene.hpp"

namespace voxatlas::test {

Scene::Scene() : frame_(EnuFrame::at(Geodetic{48.1493, 11.5685, 560}).value()) {}

void Scene::occupy(const Eigen::Vector3d& p_enu, std::optional<Rgb> rgb) {
  const VoxelIndex voxel = grid_.voxel_at(frame_.to_ecef(p_enu)).value();
  CellState state{3000, {}};
  if (rgb) state.colour.add(*rgb);
  tiles_[grid_.tile_of(voxel)].set(CellKey::of_voxel(Grid::in_tile(voxel), kDepth), state);
}

void Scene::occupy_box(const Eigen::Vector3d& min_enu, const Eigen::Vector3d& max_enu,
                       std::optional<Rgb> rgb) {
  constexpr double kStep = 0.04;
  for (double x = min_enu.x(); x <= max_enu.x(); x += kStep) {
    for (double y = min_enu.y(); y <= max_enu.y(); y += kStep) {
      for (double z = min_enu.z(); z <= max_enu.z(); z += kStep) occupy({x, y, z}, rgb);
    }
  }
}

std::vector<TileKey> Scene::keys() const {
  std::vector<TileKey> keys;
  for (const auto& [key, tree] : tiles_) keys.push_back(key);
  return keys;
}

std::vector<TileWeight> Scene::weights() const {
  std::vector<TileWeight> weights;
  for (const auto& [key, tree] : tiles_) weights.push_back({key, tree.counts().occupied_voxels});
  return weights;
}

Result<Camera> Scene::camera(const Eigen::Vector3d& eye_enu, const Eigen::Vector3d& target_enu,
                             const Lens& lens) const {
  return Camera::look_at(frame_.to_ecef(eye_enu), frame_.to_ecef(target_enu), frame_.up_ecef(),
                         lens);
}

Clouds::Clouds(const Scene& scene, int depth) {
  clouds_.reserve(scene.tiles().size());  // Clouds must not move: placed_ points at them.
  for (const auto& [key, tree] : scene.tiles()) {
    clouds_.emplace_back(tree, depth);
    placed_.push_back({key, &clouds_.back()});
  }
}

Scene street_scene() {
  static const Scene kStreet = [] {
    Scene scene;
    scene.occupy_box({-40, -6, 0}, {40, 6, 0}, Rgb{90, 90, 95});
    scene.occupy_box({-40, 6, 0}, {40, 6, 5}, Rgb{200, 160, 120});
    scene.occupy_box({-40, -6, 0}, {40, -6, 5}, Rgb{180, 120, 100});
    scene.occupy_box({12, 3, 0.2}, {16, 4.6, 1.5}, Rgb{200, 20, 20});
    return scene;
  }();
  return kStreet;
}

}  // namespace voxatlas::test
