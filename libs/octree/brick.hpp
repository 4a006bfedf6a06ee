#pragma once

#include <array>

#include "octree/brick_mask.hpp"
#include "octree/log_odds.hpp"

namespace voxatlas {

/// The 512 voxels of one depth-4 cell: log-odds in the order [z][y][x], and which are known.
/// An unknown voxel's log-odds are 0, which is also what an update counts it as.
struct alignas(64) Brick {
  std::array<LogOdds, kBrickVoxels> log_odds{};
  VoxelMask known{};

  friend bool operator==(const Brick&, const Brick&) = default;
};

/// The inner loops of the map, all here so that they can be made faster in one place.

/// Adds model.miss to the voxels of `misses`, then model.hit to those of `hits`, each clamped; the
/// voxels become known. No other voxel changes, not even to be clamped.
void update(Brick& brick, const VoxelMask& misses, const VoxelMask& hits, const SensorModel& model);

/// Makes the voxels of the mask known with these log-odds, or unknown.
void assign(Brick& brick, const VoxelMask& voxels, LogOdds log_odds);
void forget(Brick& brick, const VoxelMask& voxels);

/// True when every voxel is known and all have the same log-odds.
bool is_uniform(const Brick& brick);

/// The voxels with these log-odds; unknown ones have 0.
VoxelMask equal_to(const Brick& brick, LogOdds log_odds);

/// Those voxels of the mask that are below 0.
VoxelMask free_among(const Brick& brick, const VoxelMask& voxels);

}  // namespace voxatlas
