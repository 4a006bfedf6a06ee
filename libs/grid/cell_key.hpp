#pragma once

#include <compare>
#include <cstdint>

#include "grid/morton.hpp"

namespace voxatlas {

/// Levels below a tile's root, d_tile of the paper: depth 0 is the tile, depth 7 a voxel. A
/// constant: the layout of bricks rests on it.
inline constexpr int kDepth = 7;

/// Voxels along a tile's edge, 2^kDepth.
inline constexpr int kTileVoxels = 1 << kDepth;

/// The depth of a brick, 8x8x8 voxels, and bricks in a tile. Words of the implementation.
inline constexpr int kBrickDepth = 4;
inline constexpr int kBricks = 1 << 3 * kBrickDepth;

/// A node of a tile's octree: depth 0..7 and Morton code among the 8^depth cells of that depth.
/// A plain value; whoever makes one keeps code < 8^depth.
struct CellKey {
  std::uint8_t depth = 0;
  std::uint32_t code = 0;

  /// The cell of `depth` that holds the voxel (x, y, z), each 0..127 from the tile's lower corner.
  static CellKey of_voxel(const Index3& voxel, int depth);

  /// The lowest voxel of the cell, and its edge in voxels.
  Index3 min_voxel() const;
  std::uint32_t edge_voxels() const { return 1u << (kDepth - depth); }

  CellKey parent() const { return {static_cast<std::uint8_t>(depth - 1), code >> 3}; }
  CellKey child(std::uint32_t octant) const {
    return {static_cast<std::uint8_t>(depth + 1), code << 3 | octant};
  }
  /// True for the cell itself and everything below it.
  bool contains(CellKey other) const {
    return other.depth >= depth && other.code >> 3 * (other.depth - depth) == code;
  }

  friend auto operator<=>(CellKey, CellKey) = default;
};

}  // namespace voxatlas
