#include "octree/brick_update.hpp"

namespace voxatlas {
namespace {

/// True when no voxel of a uniform brick would change: free space seen once more at its clamp.
bool at_rest(const BrickTable& table, unsigned brick, const VoxelMask& misses,
             const VoxelMask& hits, const SensorModel& model) {
  if (!table.is_uniform(brick)) return false;
  const LogOdds log_odds = table.uniform_log_odds(brick);
  return (model.update(log_odds, model.miss) == log_odds || !any_of(misses)) &&
         (model.update(log_odds, model.hit) == log_odds || !any_of(hits));
}

/// A voxel that falls below 0 loses its colour.
void drop_free_colours(BrickTable& table, unsigned brick, const VoxelMask& misses) {
  const BrickColours* colours = table.colours(brick);
  if (colours == nullptr) return;
  const VoxelMask candidates = both(colours->voxels(), misses);
  if (!any_of(candidates)) return;
  table.colours_of(brick).remove(free_among(table.mixed(brick), candidates));
}

}  // namespace

void update_voxels(BrickTable& table, unsigned brick, const VoxelMask& misses,
                   const VoxelMask& hits, const SensorModel& model) {
  if (at_rest(table, brick, misses, hits, model)) return;
  update(table.expand(brick), misses, hits, model);
  drop_free_colours(table, brick, misses);
}

void colour_voxels(BrickTable& table, unsigned brick, const VoxelMask& coloured,
                   std::span<const Rgb> seen) {
  VoxelMask occupied = coloured;
  if (table.is_mixed(brick)) {
    const VoxelMask still_free = free_among(table.mixed(brick), coloured);
    for (std::size_t z = 0; z < 8; ++z) occupied[z] &= ~still_free[z];
  } else if (table.uniform_log_odds(brick) < 0) {
    return;
  }
  if (!any_of(occupied)) return;
  table.expand(brick);
  table.colours_of(brick).add(occupied, seen);
}

void miss_brick(BrickTable& table, unsigned brick, const SensorModel& model) {
  if (table.is_empty(brick)) return table.make_uniform(brick, {model.update(0, model.miss), {}});
  if (table.is_uniform(brick)) {
    const LogOdds before = table.uniform_log_odds(brick);
    return table.set_uniform_log_odds(brick, model.update(before, model.miss));
  }
  update_voxels(table, brick, kAllVoxels, kNoVoxels, model);
  table.settle(brick);
}

void hit_brick(BrickTable& table, unsigned brick, const SensorModel& model,
               const std::optional<Rgb>& seen) {
  if (!table.is_mixed(brick)) {
    CellState state = table.is_empty(brick) ? CellState{} : table.uniform_state(brick);
    state.log_odds = model.update(state.log_odds, model.hit);
    if (seen && state.log_odds >= 0) state.colour.add(*seen);
    return table.make_uniform(brick, state);
  }
  update_voxels(table, brick, kNoVoxels, kAllVoxels, model);
  if (seen) {
    std::array<Rgb, kBrickVoxels> everywhere;
    everywhere.fill(*seen);
    colour_voxels(table, brick, kAllVoxels, everywhere);
  }
  table.settle(brick);
}

void set_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels,
                const CellState& state) {
  if (voxels == kAllVoxels) return table.make_uniform(brick, state);
  assign(table.expand(brick), voxels, state.log_odds);
  if (state.colour.exists()) {
    table.colours_of(brick).assign(voxels, state.colour);
  } else if (table.colours(brick) != nullptr) {
    table.colours_of(brick).remove(voxels);
  }
  table.settle(brick);
}

void erase_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels) {
  if (table.is_empty(brick)) return;
  if (voxels == kAllVoxels) return table.make_empty(brick);
  forget(table.expand(brick), voxels);
  if (table.colours(brick) != nullptr) table.colours_of(brick).remove(voxels);
  table.settle(brick);
}

}  // namespace voxatlas
