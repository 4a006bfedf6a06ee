#include "render/cell_cloud.hpp"

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "render/occupied_cells.hpp"

namespace voxatlas {
namespace {

DrawnCell drawn(const Leaf& leaf, const OccupiedCells& occupied) {
  const Index3 min = leaf.cell.min_voxel();
  DrawnCell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell.centre[axis] = static_cast<std::int16_t>(2 * min[axis] + leaf.cell.edge_voxels());
  }
  cell.log_odds = leaf.state.log_odds;
  cell.depth = leaf.cell.depth & 0x7f;
  if (leaf.state.colour.exists()) {
    cell.rgb = leaf.state.colour.rgb();
    cell.coloured = 1;
  }
  const Eigen::Vector3f normal = occupied.normal(leaf.cell) * 127;
  for (int axis = 0; axis < 3; ++axis) {
    cell.normal[static_cast<std::size_t>(axis)] =
        static_cast<std::int8_t>(std::lround(normal[axis]));
  }
  return cell;
}

}  // namespace

CellCloud::CellCloud(const TileTree& tree, int depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  OccupiedCells occupied(depth);
  std::vector<Leaf> leaves;
  tree.for_each_cell(depth, [&](const Leaf& leaf) {
    if (!is_occupied(leaf.state.log_odds)) return;
    occupied.insert(leaf.cell);
    leaves.push_back(leaf);
  });
  std::erase_if(leaves, [&](const Leaf& leaf) { return occupied.surround(leaf.cell); });
  std::stable_sort(leaves.begin(), leaves.end(),
                   [](const Leaf& a, const Leaf& b) { return a.cell.depth < b.cell.depth; });
  cells_.reserve(leaves.size());
  for (const Leaf& leaf : leaves) cells_.push_back(drawn(leaf, occupied));
  find_depths();
}

CellCloud::CellCloud(std::vector<DrawnCell> cells) : cells_(std::move(cells)) { find_depths(); }

void CellCloud::find_depths() {
  for (std::size_t d = 0; d < begin_.size(); ++d) {
    const auto first =
        std::lower_bound(cells_.begin(), cells_.end(), d,
                         [](const DrawnCell& c, std::size_t of) { return c.depth < of; });
    begin_[d] = static_cast<std::uint32_t>(first - cells_.begin());
  }
}

std::span<const DrawnCell> CellCloud::cells_of_depth(int depth) const {
  const auto d = static_cast<std::size_t>(depth);
  return cells().subspan(begin_[d], begin_[d + 1] - begin_[d]);
}

}  // namespace voxatlas
