#pragma once

#include <array>
#include <vector>

#include "codec/pyramid.hpp"
#include "codec/range_coder.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {

/// The colours of one brick, and what stands for them where the tile is cut above its voxels.
struct ColouredBrick {
  unsigned brick = 0;
  Colour mean;           ///< Of its coloured voxels, rounded; its count is their largest.
  unsigned voxels = 0;   ///< How many are coloured, 1..512.
  bool uniform = false;  ///< All 512, with `mean`.
  /// In Morton order, if not uniform; those that do not exist too.
  std::array<Colour, kBrickVoxels> colours{};
};

/// The colours of a tile, by rising brick. Memory: at most 4096 bricks of 4.2 kB, 17 MB.
struct TileColours {
  std::vector<ColouredBrick> bricks;
};

TileColours colours_of(const BrickTable& table);

/// Puts colours into the bricks of a tile cut at `depth`.
void paint(const TileColours& colours, int depth, BrickTable& table);

}  // namespace voxatlas
