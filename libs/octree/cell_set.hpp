#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "grid/cell_key.hpp"

namespace voxatlas {

/// A voxel mask of one brick: bit 8 y + x of word z. A brick's number is its Morton code, 0..4095.
struct BrickMask {
  std::uint16_t brick = 0;
  std::array<std::uint64_t, 8> bits{};

  friend bool operator==(const BrickMask&, const BrickMask&) = default;
};

/// A set of cells of one tile, all at one depth.
///
/// Layout: depth 0..4: one bit for each of the 8^depth cells, in Morton order, in `coarse` (empty
///         when no cell is set, else exactly ceil(8^depth / 64) words); `bricks` is empty.
///         depth 5..7: voxel masks of bricks, ascending by brick, none of them empty, a cell of
///         depth 5 or 6 having all its voxels set or none; `coarse` is empty.
struct CellSet {
  int depth = kDepth;
  std::vector<std::uint64_t> coarse;
  std::vector<BrickMask> bricks;

  bool empty() const { return coarse.empty() && bricks.empty(); }
  /// Cells, not voxels, in the set.
  std::uint64_t size() const;
  /// True when the layout above holds; what a decoder checks.
  bool valid() const;
  /// Every cell once: depth <= 4 in Morton order; else by brick, then z, y, x of its lowest voxel.
  /// This is the order of a delta's colours.
  void for_each(const std::function<void(CellKey)>& visit) const;
  bool contains(CellKey cell) const;  ///< `cell` at this set's depth.
  void insert(CellKey cell);          ///< For tests and small sets; a scan's sets are built whole.

  friend bool operator==(const CellSet&, const CellSet&) = default;
};

}  // namespace voxatlas
