#include "octree/tile_apply.hpp"

#include <algorithm>
#include <bit>

#include "base/check.hpp"
#include "octree/brick_update.hpp"

namespace voxatlas {
namespace {

/// Calls visit(cell code, bricks) for every cell of a coarse set.
template <class Visit>
void for_each_coarse(const CellSet& set, Visit visit) {
  for (std::size_t i = 0; i < set.coarse.size(); ++i) {
    for (std::uint64_t word = set.coarse[i]; word != 0; word &= word - 1) {
      const auto code =
          static_cast<std::uint32_t>(64 * i) + static_cast<std::uint32_t>(std::countr_zero(word));
      visit(code, BrickRange::of({static_cast<std::uint8_t>(set.depth), code}));
    }
  }
}

void apply_coarse_misses(BrickTable& table, const CellSet& misses, const SensorModel& model) {
  for_each_coarse(misses, [&](std::uint32_t, BrickRange range) {
    for (unsigned i = 0; i < range.count; ++i) miss_brick(table, range.first + i, model);
  });
}

void apply_coarse_hits(BrickTable& table, const TileDelta& delta, const SensorModel& model) {
  std::size_t next_colour = 0;
  for_each_coarse(delta.hits, [&](std::uint32_t code, BrickRange range) {
    std::optional<Rgb> seen;
    if (!delta.coloured.coarse.empty() && (delta.coloured.coarse[code / 64] >> code % 64 & 1)) {
      seen = delta.colours[next_colour++];
    }
    for (unsigned i = 0; i < range.count; ++i) hit_brick(table, range.first + i, model, seen);
  });
}

/// The masks of one set, given out brick by brick in ascending order.
class MaskCursor {
 public:
  explicit MaskCursor(const CellSet& set) : at_(set.bricks.begin()), end_(set.bricks.end()) {}

  unsigned brick() const { return at_ == end_ ? unsigned{kBricks} : at_->brick; }
  const VoxelMask& take(unsigned wanted) {
    if (brick() != wanted) return kNoVoxels;
    return (at_++)->bits;
  }

 private:
  std::vector<BrickMask>::const_iterator at_, end_;
};

void apply_colours(BrickTable& table, unsigned brick, const VoxelMask& coloured, int depth,
                   const Rgb*& next) {
  std::array<Rgb, kBrickVoxels> seen;
  for_each_bit(both(coloured, lowest_voxels(depth)), [&](unsigned lowest) {
    const Rgb colour = *next++;
    if (depth == kDepth) {
      seen[lowest] = colour;
    } else {
      for_each_bit(cell_voxels(lowest, depth), [&](unsigned voxel) { seen[voxel] = colour; });
    }
  });
  colour_voxels(table, brick, coloured, seen);
}

void apply_bricks(BrickTable& table, const TileDelta& delta, const SensorModel& model) {
  MaskCursor misses(delta.misses), hits(delta.hits), coloured(delta.coloured);
  const Rgb* next_colour = delta.colours.data();
  for (;;) {
    const unsigned brick = std::min(misses.brick(), hits.brick());
    if (brick == kBricks) return;
    const VoxelMask& missed = misses.take(brick);
    const VoxelMask& hit = hits.take(brick);
    const bool has_colours = coloured.brick() == brick;
    update_voxels(table, brick, missed, hit, model);
    if (has_colours) {
      apply_colours(table, brick, coloured.take(brick), delta.coloured.depth, next_colour);
    }
    table.settle(brick);
  }
}

}  // namespace

void apply_delta(BrickTable& table, const TileDelta& delta, const SensorModel& model) {
  VOX_CHECK(delta.colours.size() == delta.coloured.size());
  VOX_CHECK(delta.coloured.empty() || delta.coloured.depth == delta.hits.depth);
  apply_coarse_misses(table, delta.misses, model);
  apply_bricks(table, delta, model);
  apply_coarse_hits(table, delta, model);
}

}  // namespace voxatlas
