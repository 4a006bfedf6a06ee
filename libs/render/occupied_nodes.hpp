#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octree/tile_tree.hpp"

namespace voxatlas {

/// A node of a tile's canonical octree with anything occupied inside.
struct OccupiedNode {
  std::uint32_t code = 0;  ///< Morton code among the cells of its depth.
  CellState state;         ///< As TileTree::cell gives it.
};

/// All of them down to a depth, depth by depth, each in Morton order. Unlike
/// TileTree::for_each_cell, which goes through the tile once a depth, this does it once for all.
std::array<std::vector<OccupiedNode>, kDepth + 1> occupied_nodes(const TileTree& tree,
                                                                 int max_depth);

}  // namespace voxatlas
