#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "base/bytes.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {

/// What a voxel holds: its log-odds, or that nothing is known. Compares as places do.
using Content = std::int32_t;
inline constexpr Content kNothing = std::numeric_limits<Content>::min();

/// A brick's mask, in Morton order: which voxels are not the ground.
inline constexpr std::size_t kMaskBytes = kBrickVoxels / 8;

/// The log-odds of a tile as the fast codec writes them, but for the palette, which is known only
/// when all has been read: one pass over the bricks. What is what: FORMAT.md, "fast".
/// Cost: mostly a comparison a voxel, in vectors, for each of the few contents that are common in a
///       brick, to find the commonest; then its exceptions, one by one.
struct FastContent {
  Bytes kinds = Bytes(kBricks);     ///< Pyramid::Kind of every slot.
  std::vector<Content> ground;      ///< Of every slot that is not empty.
  std::vector<Content> highest;     ///< Of every mixed slot.
  Bytes masks;                      ///< kMaskBytes for every mixed slot.
  std::vector<Content> exceptions;  ///< What their voxels hold.
};

FastContent fast_content_of(const BrickTable& table);

}  // namespace voxatlas
