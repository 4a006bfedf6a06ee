#pragma once

#include <span>

#include "octree/brick_table.hpp"

namespace voxatlas {

/// Updates of one brick of a tile, uniform ones in O(1). Each leaves the table settled, but for
/// update_voxels and colour_voxels, which want a settle() after the last of them.

void update_voxels(BrickTable& table, unsigned brick, const VoxelMask& misses,
                   const VoxelMask& hits, const SensorModel& model);
/// Colours seen at voxels that were hit, read at those voxels from 512 entries; they count only
/// where the voxel is occupied now.
void colour_voxels(BrickTable& table, unsigned brick, const VoxelMask& coloured,
                   std::span<const Rgb> seen);

/// The same for all 512 voxels.
void miss_brick(BrickTable& table, unsigned brick, const SensorModel& model);
void hit_brick(BrickTable& table, unsigned brick, const SensorModel& model,
               const std::optional<Rgb>& seen);

void set_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels, const CellState& state);
void erase_voxels(BrickTable& table, unsigned brick, const VoxelMask& voxels);

}  // namespace voxatlas
