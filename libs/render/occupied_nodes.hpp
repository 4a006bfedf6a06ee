#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octree/tile_tree.hpp"
#include "render/cell_paint.hpp"

namespace voxatlas {

/// The nodes of one depth of a tile's canonical octree with anything occupied inside, in Morton
/// order: as many of each.
struct NodesOfDepth {
  std::vector<CellPaint> paints;  ///< Of their states, as TileTree::cell gives them.
  /// Which of their children are among the next depth's nodes, a bit each; only above the last
  /// depth that was asked for.
  std::vector<std::uint8_t> octants;
};

/// All of them down to a depth. Unlike TileTree::for_each_cell, which goes through the tile once a
/// depth, this does it once for all.
std::array<NodesOfDepth, kDepth + 1> occupied_nodes(const TileTree& tree, int max_depth);

}  // namespace voxatlas
