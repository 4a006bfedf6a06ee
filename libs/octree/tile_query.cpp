// The const half of TileTree: what it knows, at a voxel, of a cell, leaf by leaf.
#include "base/check.hpp"
#include "octree/tile_state.hpp"
#include "octree/tile_walk.hpp"

namespace voxatlas {
namespace {

/// A voxel's state, read where it stands.
std::optional<CellState> voxel_state(const BrickTable& table, CellKey cell) {
  const unsigned brick = brick_of(cell);
  if (table.is_empty(brick)) return std::nullopt;
  if (table.is_uniform(brick)) return table.uniform_state(brick);
  const unsigned voxel = lowest_voxel_of(cell);
  const Brick& content = table.mixed(brick);
  if (!has_voxel(content.known, voxel)) return std::nullopt;
  const BrickColours* own = table.colours(brick);
  return CellState{content.log_odds[voxel], own == nullptr ? Colour{} : own->at(voxel)};
}

void check_cell(CellKey cell) {
  VOX_CHECK(cell.depth <= kDepth && cell.code >> 3 * cell.depth == 0);
}

}  // namespace

std::optional<CellState> TileTree::voxel(const Index3& voxel) const {
  VOX_CHECK((voxel[0] | voxel[1] | voxel[2]) < kTileVoxels);
  if (state_ == nullptr) return std::nullopt;
  return voxel_state(state_->bricks, CellKey::of_voxel(voxel, kDepth));
}

std::optional<CellState> TileTree::cell(CellKey cell) const {
  check_cell(cell);
  if (state_ == nullptr) return std::nullopt;
  const BrickTable& table = state_->bricks;
  if (cell.depth == kDepth) return voxel_state(table, cell);
  Summary summary;
  if (cell.depth <= kBrickDepth) {
    summarise(table, BrickRange::of(cell), summary);
  } else if (table.is_mixed(brick_of(cell))) {
    MortonBrick(table, brick_of(cell)).add_to(summary, run_first(cell), run_count(cell));
  } else if (!table.is_empty(brick_of(cell))) {
    return table.uniform_state(brick_of(cell));
  }
  return summary.state();
}

std::optional<CellState> TileTree::uniform(CellKey cell) const {
  check_cell(cell);
  if (state_ == nullptr) return std::nullopt;
  const BrickTable& table = state_->bricks;
  if (cell.depth == kDepth) return voxel_state(table, cell);
  if (cell.depth <= kBrickDepth) return table.uniform(BrickRange::of(cell));
  const unsigned brick = brick_of(cell);
  if (!table.is_mixed(brick)) return table.uniform({brick, 1});
  return MortonBrick(table, brick).uniform(run_first(cell), run_count(cell));
}

void TileTree::for_each_leaf(const std::function<void(const Leaf&)>& visit) const {
  for_each_cell(kDepth, visit);
}

std::vector<Leaf> TileTree::leaves() const {
  std::vector<Leaf> result;
  for_each_leaf([&](const Leaf& leaf) { result.push_back(leaf); });
  return result;
}

void TileTree::for_each_cell(int depth, const std::function<void(const Leaf&)>& visit) const {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  if (state_ != nullptr) TileWalk(state_->bricks, depth, visit).run();
}

TileTree::Counts TileTree::counts() const {
  Counts counts;
  if (state_ == nullptr) return counts;
  const TileWalk::Visit count = [&](const Leaf& leaf) {
    const std::uint64_t voxels = std::uint64_t{1} << 3 * (kDepth - leaf.cell.depth);
    const bool occupied = is_occupied(leaf.state.log_odds);
    ++counts.leaves;
    ++(occupied ? counts.occupied_leaves : counts.free_leaves);
    (occupied ? counts.occupied_voxels : counts.free_voxels) += voxels;
    counts.coloured_leaves += leaf.state.colour.exists() ? 1 : 0;
  };
  TileWalk walk(state_->bricks, kDepth, count);
  walk.run();
  counts.inner = walk.inner();
  return counts;
}

}  // namespace voxatlas
