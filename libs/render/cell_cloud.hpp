#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/cell_key.hpp"
#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// One cell to draw.
///
/// Units: half voxels from the tile's lower corner to the cell's middle: 1..255, exact. The normal
///        in 1/127, either way round; zero where there is none (OccupiedCells::normal).
/// Cost:  16 bytes, laid out so that GL reads the place straight from an array of them.
struct DrawnCell {
  std::array<std::int16_t, 3> centre{};
  LogOdds log_odds = 0;
  Rgb rgb;
  std::uint8_t depth : 7 = 0;
  std::uint8_t coloured : 1 = 0;  ///< 0: rgb says nothing.
  std::array<std::int8_t, 3> normal{};

  Eigen::Vector3f centre_voxels() const {
    return Eigen::Vector3f(centre[0], centre[1], centre[2]) * 0.5f;
  }
};
static_assert(sizeof(DrawnCell) == 16);

/// What can be drawn of one tile, at one depth: its occupied cells.
///
/// Source:  the paper's section 3.4; leaves above `depth` stay whole, below it a cell has the
///          highest log-odds inside (TileTree::cell).
/// Order:   by depth, so that cells of one size lie together; by Morton code within.
/// Hidden:  a cell whose six faces all touch occupied space of the same tile is left out: from
///          outside nobody sees it.
/// Threads: never changes; safe to share.
class CellCloud {
 public:
  CellCloud() = default;
  CellCloud(const TileTree& tree, int depth);
  /// Of cells in order of depth.
  explicit CellCloud(std::vector<DrawnCell> cells);

  std::span<const DrawnCell> cells() const { return cells_; }
  /// Those of one size.
  std::span<const DrawnCell> cells_of_depth(int depth) const;
  std::size_t memory_bytes() const { return sizeof *this + cells_.capacity() * sizeof(DrawnCell); }

 private:
  void find_depths();

  std::vector<DrawnCell> cells_;
  std::array<std::uint32_t, kDepth + 2> begin_{};  // Of each depth; then the end.
};

/// Places a cloud on the grid.
struct PlacedCloud {
  TileKey key;
  const CellCloud* cloud = nullptr;
};

}  // namespace voxatlas
