#include "bench/truth_case.hpp"

namespace voxatlas::bench {
namespace {

constexpr double kOnSurface = 0.05;  ///< Exact points lie on a surface to within rounding.

}  // namespace

Eigen::Vector3d middle_of(TileKey tile, std::uint32_t code) {
  const Box box = Grid::standard().box(tile, {kDepth, code});
  return (box.min + box.max) / 2;
}

void Truth::add(const Scan& exact, const Instant& instant) {
  const Grid grid = Grid::standard();
  for (const Eigen::Vector3d& endpoint : exact.endpoints_ecef) {
    const VoxelIndex voxel = grid.voxel_unchecked(endpoint);
    const TileKey tile = grid.tile_of(voxel);
    const auto code = CellKey::of_voxel(Grid::in_tile(voxel), kDepth).code;
    const auto [at, is_new] = tiles_[tile].try_emplace(code);
    at->second.seen_through = 0;
    if (!is_new) continue;
    const auto surface = instant.nearest(city_.to_city(endpoint), kOnSurface);
    at->second.material = surface.material;
    at->second.moves = surface.moves;
    if (surface.moves) trails_[tile].push_back(code);
  }
  const auto carved = *carver_.integrate(exact);
  for (const auto& [key, delta] : carved.tiles) {
    const auto trail = trails_.find(key);
    if (trail == trails_.end()) continue;
    for (const std::uint32_t code : trail->second) {
      if (delta.misses.contains({kDepth, code})) ++tiles_.at(key).at(code).seen_through;
    }
  }
}

}  // namespace voxatlas::bench
