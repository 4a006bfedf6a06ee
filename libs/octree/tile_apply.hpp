#pragma once

#include "octree/brick_table.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {

/// TileTree::apply, a brick at a time: misses and hits of a brick in one visit.
void apply_delta(BrickTable& table, const TileDelta& delta, const SensorModel& model);

}  // namespace voxatlas
