#pragma once

#include "octree/brick_table.hpp"

namespace voxatlas {

/// What stands behind a TileTree that knows anything; an empty one need not have it.
struct TileTree::State {
  BrickTable bricks;
};

}  // namespace voxatlas
