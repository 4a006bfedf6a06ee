#pragma once

#include "octree/brick_table.hpp"
#include "octree/morton_brick.hpp"

namespace voxatlas {

/// The canonical octree of a tile, walked in Morton order, depth first, cut at a depth.
class TileWalk {
 public:
  using Visit = std::function<void(const Leaf&)>;

  TileWalk(const BrickTable& table, int depth, const Visit& visit)
      : table_(table), depth_(depth), visit_(visit) {}

  void run() { walk({0, 0}); }
  std::uint64_t inner() const { return inner_; }  ///< Inner nodes met, those at the cut among them.

 private:
  void walk(CellKey cell);
  void walk_brick(const MortonBrick& brick, CellKey cell);

  const BrickTable& table_;
  const int depth_;
  const Visit& visit_;
  std::uint64_t inner_ = 0;
};

/// Adds all that is known in these bricks.
void summarise(const BrickTable& table, BrickRange range, Summary& summary);

/// Where the voxels of a cell of depth 4..7 stand in its MortonBrick.
inline unsigned run_first(CellKey cell) {
  return cell.code << 3 * (kDepth - cell.depth) & (kBrickVoxels - 1);
}
inline unsigned run_count(CellKey cell) { return 1u << 3 * (kDepth - cell.depth); }

}  // namespace voxatlas
