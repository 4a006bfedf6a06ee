#include "octree/tile_walk.hpp"

namespace voxatlas {

void summarise(const BrickTable& table, BrickRange range, Summary& summary) {
  for (unsigned brick = range.first; brick < range.first + range.count; ++brick) {
    if (table.is_mixed(brick)) {
      summary.add(table.mixed(brick), table.colours(brick));
    } else if (!table.is_empty(brick)) {
      summary.add(table.uniform_state(brick), kBrickVoxels);
    }
  }
}

void TileWalk::walk(CellKey cell) {
  const BrickRange range = BrickRange::of(cell);
  if (table_.is_empty(range)) return;
  if (const auto state = table_.uniform(range)) return visit_({cell, *state});
  if (cell.depth == kBrickDepth && depth_ > kBrickDepth) {
    return walk_brick(MortonBrick(table_, range.first), cell);
  }
  ++inner_;
  if (cell.depth == depth_) {
    Summary summary;
    summarise(table_, range, summary);
    return visit_({cell, *summary.state()});
  }
  for (std::uint32_t octant = 0; octant < 8; ++octant) walk(cell.child(octant));
}

void TileWalk::walk_brick(const MortonBrick& brick, CellKey cell) {
  const unsigned first = run_first(cell), count = run_count(cell);
  if (brick.is_empty(first, count)) return;
  if (const auto state = brick.uniform(first, count)) return visit_({cell, *state});
  ++inner_;
  if (cell.depth == depth_) {
    Summary summary;
    brick.add_to(summary, first, count);
    return visit_({cell, *summary.state()});
  }
  for (std::uint32_t octant = 0; octant < 8; ++octant) walk_brick(brick, cell.child(octant));
}

}  // namespace voxatlas
