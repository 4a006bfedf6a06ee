#include "integrate/carve.hpp"

#include "grid/walk.hpp"

namespace voxatlas {
namespace {

/// Cells of depth 5..7: looks a brick up only where the ray enters one.
void carve_bricks(Walk& walk, Marks& misses) {
  const int shift = misses.depth() - kBrickDepth;
  const int up = kDepth - misses.depth();
  Eigen::Vector3i brick(-1, -1, -1);
  std::uint64_t* words = nullptr;
  for (auto left = walk.remaining(); left > 0; --left) {
    const Eigen::Vector3i cell = walk.cell();
    const int x = cell.x() >> shift, y = cell.y() >> shift, z = cell.z() >> shift;
    if (((x ^ brick.x()) | (y ^ brick.y()) | (z ^ brick.z())) != 0) {
      brick = {x, y, z};
      const auto top = [](int v) { return static_cast<std::uint32_t>(v) & 15; };
      const auto tile = misses.tile_slot(cell);
      words = misses.bits(misses.brick_slot(tile, top_bit(top(x), top(y), top(z)))).data();
    }
    words[cell.z() << up & 7] |= std::uint64_t{1}
                                 << ((cell.y() << up & 7) << 3 | (cell.x() << up & 7));
    walk.step();
  }
}

void carve_coarse(Walk& walk, Marks& misses) {
  const std::uint32_t wrap = (1u << misses.depth()) - 1;
  for (auto left = walk.remaining(); left > 0; --left) {
    const Eigen::Vector3i& cell = walk.cell();
    const auto top = [&](int axis) { return static_cast<std::uint32_t>(cell[axis]) & wrap; };
    misses.tile(misses.tile_slot(cell)).set(top_bit(top(0), top(1), top(2)));
    walk.step();
  }
}

}  // namespace

void carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, Marks& misses) {
  Walk walk(origin_voxels, end_voxels, kDepth - misses.depth());
  if (misses.has_bricks()) {
    carve_bricks(walk, misses);
  } else {
    carve_coarse(walk, misses);
  }
}

}  // namespace voxatlas
