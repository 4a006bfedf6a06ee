#include "octree/tile_tree.hpp"

#include "base/check.hpp"
#include "octree/brick_update.hpp"
#include "octree/tile_apply.hpp"
#include "octree/tile_state.hpp"

namespace voxatlas {
namespace {

void check_cell(CellKey cell) {
  VOX_CHECK(cell.depth <= kDepth && cell.code >> 3 * cell.depth == 0);
}

/// Calls visit(brick number, voxels) for the bricks of a cell and the voxels of it in each.
template <class Visit>
void for_each_brick(CellKey cell, Visit visit) {
  if (cell.depth > kBrickDepth) {
    return visit(brick_of(cell), cell_voxels(lowest_voxel_of(cell), cell.depth));
  }
  const BrickRange range = BrickRange::of(cell);
  for (unsigned i = 0; i < range.count; ++i) visit(range.first + i, kAllVoxels);
}

void hit_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels,
                const SensorModel& model, const std::optional<Rgb>& seen) {
  if (voxels == kAllVoxels) return hit_brick(table, brick, model, seen);
  update_voxels(table, brick, kNoVoxels, voxels, model);
  if (seen) {
    std::array<Rgb, kBrickVoxels> everywhere;
    everywhere.fill(*seen);
    colour_voxels(table, brick, voxels, everywhere);
  }
  table.settle(brick);
}

void miss_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels,
                 const SensorModel& model) {
  if (voxels == kAllVoxels) return miss_brick(table, brick, model);
  update_voxels(table, brick, voxels, kNoVoxels, model);
  table.settle(brick);
}

/// The state to change, made where there is none.
template <class State>
BrickTable& bricks_of(std::unique_ptr<State>& state) {
  if (state == nullptr) state = std::make_unique<State>();
  return state->bricks;
}

}  // namespace

TileTree::TileTree() = default;
TileTree::~TileTree() = default;
TileTree::TileTree(TileTree&&) noexcept = default;
TileTree& TileTree::operator=(TileTree&&) noexcept = default;

TileTree::TileTree(const TileTree& other)
    : state_(other.state_ == nullptr ? nullptr : std::make_unique<State>(*other.state_)) {}

TileTree& TileTree::operator=(const TileTree& other) { return *this = TileTree(other); }

void TileTree::hit(CellKey cell, const SensorModel& model, std::optional<Rgb> seen) {
  check_cell(cell);
  VOX_CHECK(model.valid());
  BrickTable& table = bricks_of(state_);
  for_each_brick(cell, [&](unsigned brick, const VoxelMask& voxels) {
    hit_voxels(table, brick, voxels, model, seen);
  });
}

void TileTree::miss(CellKey cell, const SensorModel& model) {
  check_cell(cell);
  VOX_CHECK(model.valid());
  BrickTable& table = bricks_of(state_);
  for_each_brick(cell, [&](unsigned brick, const VoxelMask& voxels) {
    miss_voxels(table, brick, voxels, model);
  });
}

void TileTree::apply(const TileDelta& delta, const SensorModel& model) {
  VOX_CHECK(model.valid());
  if (!delta.empty()) apply_delta(bricks_of(state_), delta, model);
}

void TileTree::set(CellKey cell, const CellState& state) {
  check_cell(cell);
  VOX_CHECK(state.colour.count <= Colour::kMaxCount);
  VOX_CHECK(state.log_odds >= 0 || !state.colour.exists());
  // Without a count there is no colour, whatever the mean says.
  const CellState plain{state.log_odds, state.colour.exists() ? state.colour : Colour{}};
  BrickTable& table = bricks_of(state_);
  for_each_brick(cell, [&](unsigned brick, const VoxelMask& voxels) {
    set_voxels(table, brick, voxels, plain);
  });
}

void TileTree::erase(CellKey cell) {
  check_cell(cell);
  if (state_ == nullptr) return;
  for_each_brick(cell, [&](unsigned brick, const VoxelMask& voxels) {
    erase_voxels(state_->bricks, brick, voxels);
  });
}

bool TileTree::empty() const { return state_ == nullptr || state_->bricks.is_empty(); }

void TileTree::prune() {
  if (empty()) {
    state_.reset();
  } else {
    state_->bricks.compact();
  }
}

std::size_t TileTree::memory_bytes() const {
  return sizeof *this + (state_ == nullptr ? 0 : state_->bricks.memory_bytes());
}

const BrickTable* TileTree::bricks() const { return state_ == nullptr ? nullptr : &state_->bricks; }

TileTree TileTree::of_bricks(BrickTable&& bricks) {
  TileTree tree;
  if (!bricks.is_empty()) tree.state_ = std::make_unique<State>(State{std::move(bricks)});
  return tree;
}

bool operator==(const TileTree& a, const TileTree& b) {
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  return a.state_->bricks == b.state_->bricks;
}

}  // namespace voxatlas
