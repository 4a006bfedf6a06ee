#include "render/splatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render/frustum.hpp"

namespace voxatlas {
namespace {

struct OrderedTile {
  int steps;  // Faces of tiles that a ray crosses on its way to it.
  const RenderTree* tree;
  SplatTile tile;
};

/// The depth at which a tile is drawn, by how large its cells look from the eye.
int depth_for(const SplatFrame& frame, const Camera& camera, const SplatTile& tile,
              const SplatOptions& options) {
  if (!(options.pixel_threshold > 0)) return options.max_depth;
  const double focal = std::max(camera.lens().fx, camera.lens().fy);
  const auto first_with = [&](double pixels_a_voxel) {
    int depth = 0;
    while (depth < options.max_depth &&
           pixels_a_voxel * (1 << (kDepth - depth)) > options.pixel_threshold) {
      ++depth;
    }
    return depth;
  };
  if (frame.map) return first_with(focal * static_cast<double>(frame.voxel_metres));
  const Eigen::Vector3d ahead = camera.rotation().row(2);
  double z = 0;  // Of the tile's corner nearest along the axis, voxels.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = ahead[static_cast<Eigen::Index>(axis)];
    z += slope * (static_cast<double>(tile.corner[axis]) - frame.in_voxel[axis]) +
         std::min(0.0, slope * kTileVoxels);
  }
  return first_with(focal / std::max<double>(z, frame.near_z));
}

/// How late a ray may enter a tile: along any ray from the eye, each face that it crosses leads one
/// step away from the eye's tile; a map's rays cross all in the same direction.
int steps_to(const SplatFrame& frame, const VoxelIndex& corner) {
  int steps = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int away = (corner[axis] >> kDepth) - (frame.eye[axis] >> kDepth);
    const double ray = frame.ray[static_cast<std::size_t>(axis)];
    steps += frame.map ? (ray < 0 ? -away : away) : std::abs(away);
  }
  return steps;
}

/// Nearest first.
std::vector<OrderedTile> tiles_to_draw(const Camera& camera, const Grid& grid,
                                       const SplatFrame& frame, std::span<const PlacedTree> trees,
                                       const SplatOptions& options) {
  const TreeNumbers numbers(trees);
  const Frustum frustum(camera);
  std::vector<OrderedTile> seen;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const PlacedTree& placed = trees[i];
    if (placed.tree->empty() || !frustum.may_see(grid.box(placed.key))) continue;
    const VoxelIndex corner = Grid::min_voxel(placed.key);
    OrderedTile ordered{steps_to(frame, corner), placed.tree, {}};
    for (int axis = 0; axis < 3; ++axis) {
      ordered.tile.corner[static_cast<std::size_t>(axis)] = corner[axis] - frame.eye[axis];
    }
    ordered.tile.links = placed.tree->links().data();
    ordered.tile.first_number = numbers.first_of(i);
    ordered.tile.depth =
        std::min(placed.tree->depth(), depth_for(frame, camera, ordered.tile, options));
    seen.push_back(ordered);
  }
  std::sort(seen.begin(), seen.end(),
            [](const OrderedTile& a, const OrderedTile& b) { return a.steps < b.steps; });
  return seen;
}

void copy_out(const SplatStrip& strip, CellImage& image) {
  for (int y = 0; y < image.height; ++y) {
    std::uint32_t* const cell = &image.cell[image.index(strip.x0, y)];
    float* const z = &image.z[image.index(strip.x0, y)];
    if (strip.begun[static_cast<std::size_t>(y / SplatStrip::kBand)] == 0) {
      std::fill_n(cell, strip.width, CellImage::kNone);
      std::fill_n(z, strip.width, CellImage::kNowhere);
      continue;
    }
    const SplatRow& row = strip.rows[static_cast<std::size_t>(y)];
    std::copy_n(row.cell.data(), strip.width, cell);
    std::copy_n(row.z.data(), strip.width, z);
  }
}

Status check(const SplatOptions& options, std::span<const PlacedTree> trees) {
  if (options.max_depth < 0 || options.max_depth > kDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("splatter: depth {} is not 0..{}", options.max_depth, kDepth));
  }
  if (!(options.pixel_threshold >= 0)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("splatter: a threshold of {} pixels is not 0 or more",
                            options.pixel_threshold));
  }
  const TreeNumbers numbers(trees);
  if (!numbers.fits()) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("splatter: a picture of {} nodes: more than 32 bits can number",
                            numbers.count()));
  }
  return {};
}

}  // namespace

Splatter::Splatter(std::size_t threads) : workers_(threads), strips_(workers_.count()) {}

Status Splatter::draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
                      const SplatOptions& options, CellImage& image) {
  if (auto good = check(options, trees); !good) return good;
  const SplatFrame frame(camera, grid);
  std::vector<SplatTile> tiles;
  drawn_ = {};
  for (const OrderedTile& seen : tiles_to_draw(camera, grid, frame, trees, options)) {
    tiles.push_back(seen.tile);
    drawn_.depth = std::max(drawn_.depth, seen.tile.depth);
    drawn_.cells += seen.tree->cell_count(seen.tile.depth);
  }
  drawn_.tiles = tiles.size();
  image.width = camera.width();
  image.height = camera.height();
  const std::size_t count = image.index(0, image.height);
  image.cell.resize(count);
  image.z.resize(count);
  const auto strips =
      static_cast<std::size_t>((image.width + Coverage::kWidth - 1) / Coverage::kWidth);
  workers_.run(strips, [&](std::size_t piece, std::size_t worker) {
    SplatStrip& strip = strips_[worker];
    const int x0 = static_cast<int>(piece) * Coverage::kWidth;
    strip.reset(frame, x0, std::min(Coverage::kWidth, image.width - x0));
    strip.cull = options.cull;
    splat(frame, tiles, strip);
    copy_out(strip, image);
  });
  return {};
}

}  // namespace voxatlas
