#include <bitset>
#include <cmath>
#include <optional>

#include "bench/truth_case.hpp"
#include "grid/walk.hpp"

namespace voxatlas::bench {
namespace {

constexpr int kNone = IntegrationParameters::kNoFreeSpace;
constexpr double kWithinACell = 0.15;  ///< From a voxel's middle to the far side of its neighbour.
constexpr double kSearch = 0.3;
constexpr std::uint32_t kLooksThatClear = 9;  ///< From the upper clamp, 0.97, by misses of 0.4.

/// Whether a voxel or one of its 26 neighbours held a vehicle.
bool near_trail(const Truth& truth, TileKey tile, std::uint32_t code) {
  const Grid grid = Grid::standard();
  const Eigen::Vector3d middle = middle_of(tile, code);
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const VoxelIndex voxel = grid.voxel_unchecked(middle + step / grid.cells_per_metre());
    const auto found = truth.tiles().find(grid.tile_of(voxel));
    if (found == truth.tiles().end()) continue;
    const auto seen = found->second.find(CellKey::of_voxel(Grid::in_tile(voxel), kDepth).code);
    if (seen != found->second.end() && seen->second.moves) return true;
  }
  return false;
}

bool occupied(const Tiles& tiles, TileKey tile, std::uint32_t code) {
  const auto found = tiles.find(tile);
  if (found == tiles.end()) return false;
  const auto state = found->second.cell({kDepth, code});
  return state && is_occupied(state->log_odds);
}

bool at_surface(const City& city, const Instant& when, const Eigen::Vector3d& middle) {
  return std::abs(when.nearest(city.to_city(middle), kSearch).distance) <= kWithinACell;
}

/// Static voxels that are occupied without free space.
struct Shared {
  double statics = 0, poles = 0;
};

/// The counts of recall and of what is cleared; shares are made of them at the end.
void compare_seen(const Tiles& tiles, const Tiles& surface, const Truth& truth, const City& city,
                  const Instant& end, Quality& sums, Shared& shared) {
  for (const auto& [key, voxels] : truth.tiles()) {
    for (const auto& [code, seen] : voxels) {
      const bool full = occupied(tiles, key, code);
      if (!seen.moves) {
        sums.statics += 1;
        sums.recall += full;
        const bool there = occupied(surface, key, code);
        shared.statics += there;
        sums.kept += there && full;
        if (seen.material != Material::kPole) continue;
        sums.pole_voxels += 1;
        sums.poles += full;
        shared.poles += there;
        sums.kept_poles += there && full;
      } else if (seen.seen_through > 0 && !at_surface(city, end, middle_of(key, code))) {
        sums.trail_any += 1;
        sums.cleared_any += !full;
        if (seen.seen_through < kLooksThatClear) continue;
        sums.trail_9 += 1;
        sums.cleared_9 += !full;
      }
    }
  }
}

/// The counts of precision.
void compare_occupied(const Tiles& tiles, const Truth& truth, const City& city, const Instant& end,
                      Quality& sums) {
  for (const auto& [key, tile] : tiles) {
    tile.for_each_leaf([&, &tile_key = key](const Leaf& leaf) {
      if (!is_occupied(leaf.state.log_odds)) return;
      const std::uint32_t voxels = 1u << 3 * (kDepth - leaf.cell.depth);
      for (std::uint32_t i = 0; i < voxels; ++i) {
        const std::uint32_t code = leaf.cell.code * voxels + i;
        const bool there = at_surface(city, end, middle_of(tile_key, code));
        sums.occupied += 1;
        sums.precision += there;
        sums.precision_then += there || near_trail(truth, tile_key, code);
      }
    });
  }
}

}  // namespace

Rule::Rule(Kind kind) : kind_(kind) {
  IntegrationParameters how;
  if (kind == Kind::kAllRays) how.all_rays_free = true;
  if (kind == Kind::kCarve) how.free_depth = kDepth;
  if (kind == Kind::kPushed || kind == Kind::kSurface) how.free_depth = kNone;
  integrator_ = std::make_unique<Integrator>(Grid::standard(), how);
}

/// Misses of all coarse cells that rays pass, whatever else lies in them.
void Rule::push_misses(const Scan& noisy) {
  const Grid grid = Grid::standard();
  const int shift = kDepth - kBrickDepth;
  std::unordered_map<TileKey, std::bitset<kBricks>> passed;
  const Eigen::Vector3d origin = grid.to_voxels(noisy.origin_ecef);
  for (const auto& endpoint : noisy.endpoints_ecef) {
    Walk walk(origin, grid.to_voxels(endpoint), shift);
    std::optional<TileKey> tile;
    std::bitset<kBricks>* cells = nullptr;
    for (; walk.remaining() > 0; walk.step()) {
      const VoxelIndex voxel = walk.cell() * (1 << shift);
      if (const TileKey at = grid.tile_of(voxel); at != tile) {
        tile = at;
        cells = &passed[at];
      }
      cells->set(CellKey::of_voxel(Grid::in_tile(voxel), kBrickDepth).code);
    }
  }
  for (const auto& [tile, cells] : passed) {
    for (std::uint32_t code = 0; code < kBricks; ++code) {
      if (cells[code]) tiles_[tile].miss({kBrickDepth, code}, SensorModel::standard());
    }
  }
}

void Rule::add(const Scan& noisy) {
  if (kind_ == Kind::kPushed) push_misses(noisy);
  const auto delta = *integrator_->integrate(noisy);
  for (const auto& [key, change] : delta.tiles) {
    tiles_[key].apply(change, SensorModel::standard());
  }
}

Quality compare(const Tiles& tiles, const Tiles& surface, const Truth& truth, const City& city,
                const Instant& end) {
  Quality sums;
  Shared shared;
  compare_seen(tiles, surface, truth, city, end, sums, shared);
  compare_occupied(tiles, truth, city, end, sums);
  const auto share = [](double& part, double of) { part = of > 0 ? part / of : 0; };
  share(sums.recall, sums.statics);
  share(sums.poles, sums.pole_voxels);
  share(sums.kept, shared.statics);
  share(sums.kept_poles, shared.poles);
  share(sums.cleared_9, sums.trail_9);
  share(sums.cleared_any, sums.trail_any);
  share(sums.precision, sums.occupied);
  share(sums.precision_then, sums.occupied);
  return sums;
}

}  // namespace voxatlas::bench
