#include "render/gl_trees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "render/tree_walk.hpp"

namespace voxatlas {
namespace {

/// The cells of a tree at a depth, and which of its nodes each is.
struct TreeCells {
  CellCloud cloud;
  std::vector<std::uint32_t> nodes;
};

TreeCells cells_of(const RenderTree& tree, int depth) {
  std::array<std::vector<DrawnCell>, kDepth + 1> cells;  // By depth, as a cloud wants them.
  std::array<std::vector<std::uint32_t>, kDepth + 1> nodes;
  walk_tree(tree, Eigen::Vector3i::Zero(), [&](const WalkedNode& walked) {
    if (walked.depth < depth && walked.children.octants != 0) return true;
    const int edge = 1 << (kDepth - walked.depth);
    DrawnCell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int place = walked.at[static_cast<Eigen::Index>(axis)];
      cell.centre[axis] = static_cast<std::int16_t>((2 * place + 1) * edge);
    }
    cell.depth = static_cast<std::uint8_t>(walked.depth) & 0x7f;
    cells[cell.depth].push_back(cell);
    nodes[cell.depth].push_back(walked.node);
    return false;
  });
  std::vector<DrawnCell> all_cells;
  TreeCells result;
  for (std::size_t d = 0; d < cells.size(); ++d) {
    all_cells.insert(all_cells.end(), cells[d].begin(), cells[d].end());
    result.nodes.insert(result.nodes.end(), nodes[d].begin(), nodes[d].end());
  }
  result.cloud = CellCloud(std::move(all_cells));
  return result;
}

}  // namespace

Result<std::unique_ptr<GlTrees>> GlTrees::create() {
  auto scene = GlScene::create();
  if (!scene) return pass_on(scene);
  return std::unique_ptr<GlTrees>(new GlTrees(std::move(*scene)));
}

Status GlTrees::draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
                     int depth, CellImage& image) {
  if (depth < 0 || depth > kDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("gl backend: depth {} is not 0..{}", depth, kDepth));
  }
  std::deque<TreeCells> cells;  // Clouds must not move: `clouds` points at them.
  std::vector<PlacedCloud> clouds;
  for (const PlacedTree& placed : trees) {
    clouds.push_back({placed.key, &cells.emplace_back(cells_of(*placed.tree, depth)).cloud});
  }
  auto drawn = scene_->draw(camera, grid, clouds);
  if (!drawn) return pass_on(drawn);
  image = std::move(*drawn);
  const CellNumbers cell_numbers(clouds);
  const TreeNumbers tree_numbers(trees);
  for (std::uint32_t& number : image.cell) {
    if (number == CellImage::kNone) continue;
    const auto found = cell_numbers.find(number);
    number = tree_numbers.first_of(found.cloud) + cells[found.cloud].nodes[found.cell];
  }
  return {};
}

}  // namespace voxatlas
