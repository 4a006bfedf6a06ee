#include "codec/dense_colours.hpp"

#include <algorithm>

#include "octree/morton_brick.hpp"

namespace voxatlas {
namespace {

ColouredBrick coloured_brick(const BrickTable& table, unsigned number) {
  ColouredBrick brick;
  brick.brick = number;
  const BrickColours& from = *table.colours(number);
  Summary summary;
  from.for_each([&](unsigned voxel, const Colour& colour) {
    summary.add({0, colour});
    ++brick.voxels;
    brick.colours[kMortonOfVoxel[voxel]] = colour;
  });
  brick.mean = summary.state()->colour;
  brick.uniform = table.is_uniform(number);
  return brick;
}

/// A brick of the whole tile.
void paint_voxels(const ColouredBrick& from, BrickTable& table) {
  VoxelMask voxels{};
  std::vector<Colour> colours;
  colours.reserve(from.voxels);
  for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
    const Colour& colour = from.colours[kMortonOfVoxel[voxel]];
    if (!colour.exists()) continue;
    voxels[voxel >> 6] |= std::uint64_t{1} << (voxel & 63);
    colours.push_back(colour);
  }
  table.expand(from.brick);  // It may have been one of equal log-odds.
  table.colours_of(from.brick) = BrickColours(voxels, std::move(colours));
  table.settle(from.brick);
}

/// A brick cut at depth 5 or 6: its occupied voxels have its mean.
void paint_mean(const ColouredBrick& from, BrickTable& table) {
  const Brick& brick = table.expand(from.brick);
  VoxelMask voxels{};
  std::vector<Colour> colours;
  for_each_bit(brick.known, [&](unsigned voxel) {
    if (!is_occupied(brick.log_odds[voxel])) return;
    voxels[voxel >> 6] |= std::uint64_t{1} << (voxel & 63);
    colours.push_back(from.mean);
  });
  if (!colours.empty()) {
    table.colours_of(from.brick) = BrickColours(voxels, std::move(colours));
  }
  table.settle(from.brick);
}

/// One colour for a cell of depth 0..4: the mean of its bricks, each as often as it has coloured
/// voxels.
void paint_cells(const TileColours& colours, int depth, BrickTable& table) {
  const unsigned count = 1u << 3 * (kBrickDepth - depth);
  for (std::size_t i = 0; i < colours.bricks.size();) {
    const unsigned first = colours.bricks[i].brick / count * count;
    Summary summary;
    for (; i < colours.bricks.size() && colours.bricks[i].brick < first + count; ++i) {
      summary.add({0, colours.bricks[i].mean}, colours.bricks[i].voxels);
    }
    const LogOdds log_odds = table.uniform_log_odds(first);
    table.make_uniform(BrickRange{first, count}, {log_odds, summary.state()->colour});
  }
}

}  // namespace

TileColours colours_of(const BrickTable& table) {
  TileColours colours;
  if (!table.has_colours()) return colours;
  for (unsigned i = 0; i < kBricks; ++i) {
    if (table.colours(i) != nullptr) colours.bricks.push_back(coloured_brick(table, i));
  }
  return colours;
}

void paint(const TileColours& colours, int depth, BrickTable& table) {
  if (depth <= kBrickDepth) return paint_cells(colours, depth, table);
  for (const auto& brick : colours.bricks) {
    if (brick.uniform) {
      table.make_uniform(brick.brick, {table.uniform_log_odds(brick.brick), brick.mean});
    } else if (depth < kDepth) {
      paint_mean(brick, table);
    } else {
      paint_voxels(brick, table);
    }
  }
}

}  // namespace voxatlas
