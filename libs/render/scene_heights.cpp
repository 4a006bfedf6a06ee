#include "render/scene_heights.hpp"

#include <algorithm>

#include "geodesy/ecef.hpp"

namespace voxatlas {
namespace {

constexpr double kGroundShare = 0.05, kTopShare = 0.99;

/// Finding where a node is costs a search: some are enough, and more would be felt in each frame.
constexpr std::uint64_t kSamples = 1000;
constexpr int kSampledDepth = 5;

}  // namespace

SceneHeights heights_of(const Eigen::Vector3d& up_ecef, std::vector<double> samples) {
  SceneHeights heights{up_ecef, 0};
  if (samples.empty()) return heights;
  const auto height_at = [&samples](double share) {
    const double place = share * static_cast<double>(samples.size() - 1);
    const auto at = samples.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(samples.begin(), at, samples.end());
    return *at;
  };
  heights.ground = height_at(kGroundShare);
  heights.rise = std::clamp(height_at(kTopShare) - heights.ground, 5.0, 25.0);
  return heights;
}

SceneHeights scene_heights(const Camera& camera, const Grid& grid,
                           std::span<const PlacedTree> trees) {
  const Eigen::Vector3d up = up_at(camera.position());
  std::uint64_t count = 0;
  const auto sampled = [](const RenderTree& tree) {
    return tree.nodes_of_depth(std::min(kSampledDepth, tree.depth()));
  };
  for (const auto& placed : trees) count += sampled(*placed.tree).count;
  const std::uint64_t every = count / kSamples + 1;
  std::vector<double> samples;
  std::uint64_t skip = 0;
  for (const auto& placed : trees) {
    const auto nodes = sampled(*placed.tree);
    for (; skip < nodes.count; skip += every) {
      const auto node = nodes.first + static_cast<std::uint32_t>(skip);
      const Box box = grid.box(placed.key, placed.tree->key_of(node));
      samples.push_back(up.dot((box.min + box.max) / 2 - camera.position()));
    }
    skip -= nodes.count;
  }
  return heights_of(up, std::move(samples));
}

}  // namespace voxatlas
