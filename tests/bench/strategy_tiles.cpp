#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "base/check.hpp"
#include "bench/import_case.hpp"
#include "bench/strategy_case.hpp"
#include "grid/walk.hpp"
#include "integrate/quality.hpp"

namespace voxatlas::bench {
namespace {

using Tiles = std::map<TileKey, TileTree>;

/// A ray as it waits for a tile, in voxels of the whole grid.
struct QueuedRay {
  Eigen::Vector3d origin, end;
  bool hit;  ///< Ends within max_range.
};
using Queues = std::map<TileKey, std::vector<QueuedRay>>;

/// Resident bytes at the largest, as the kernel counts them.
double peak_resident() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

StrategyCost cost_of(const Tiles& tiles, double began, double before, double queued) {
  StrategyCost cost{wall_seconds() - began, peak_resident() - before, queued, 0, 0};
  cost.tiles = static_cast<double>(tiles.size());
  for (const auto& [key, tile] : tiles) {
    cost.occupied_voxels += static_cast<double>(tile.counts().occupied_voxels);
  }
  return cost;
}

/// Queues the rays of a scan at every tile they pass.
void enqueue(const Scan& scan, const IntegrationParameters& how, Queues& queues) {
  const Grid grid = Grid::standard();
  const Eigen::Vector3d origin = grid.to_voxels(scan.origin_ecef);
  const bool free_space = how.free_depth != IntegrationParameters::kNoFreeSpace;
  for (const Eigen::Vector3d& endpoint : scan.endpoints_ecef) {
    Eigen::Vector3d end_ecef = endpoint;
    const double range = (endpoint - scan.origin_ecef).norm();
    const bool hit = range <= how.max_range;
    if (!hit) end_ecef = scan.origin_ecef + (endpoint - scan.origin_ecef) * (how.max_range / range);
    const QueuedRay ray{origin, grid.to_voxels(end_ecef), hit};
    if (!free_space && !hit) continue;
    Walk walk(free_space ? origin : ray.end, ray.end, kDepth);
    for (;;) {
      queues[grid.tile_of(walk.cell() * kTileVoxels)].push_back(ray);
      if (walk.remaining() == 0) break;
      walk.step();
    }
  }
}

/// Cuts a segment to a tile, a voxel wider on each side: what is outside is filtered out later, as
/// the paper does. False where they do not meet.
bool cut(const Eigen::Vector3d& low, Eigen::Vector3d& from, Eigen::Vector3d& to) {
  const Eigen::Vector3d way = to - from;
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double near = low[axis] - 1 - from[axis], far = low[axis] + kTileVoxels + 1 - from[axis];
    if (way[axis] == 0) {
      if (near > 0 || far < 0) return false;
      continue;
    }
    enter = std::max(enter, std::min(near / way[axis], far / way[axis]));
    leave = std::min(leave, std::max(near / way[axis], far / way[axis]));
  }
  if (enter > leave) return false;
  to = leave < 1 ? Eigen::Vector3d(from + leave * way) : to;
  from = from + enter * way;
  return true;
}

/// The free cells of one ray in one tile, straight into the octree; then its endpoint.
void update(TileKey key, const QueuedRay& ray, int free_depth, TileTree& tile) {
  static const SensorModel model = SensorModel::standard();
  const VoxelIndex low = Grid::min_voxel(key);
  const VoxelIndex last = ray.end.array().floor().cast<int>();
  const auto inside = [&](const VoxelIndex& voxel) {
    return ((voxel - low).array() >= 0).all() && ((voxel - low).array() < kTileVoxels).all();
  };
  Eigen::Vector3d from = ray.origin, to = ray.end;
  if (free_depth >= 0 && cut(low.cast<double>(), from, to)) {
    const int shift = kDepth - free_depth;
    const VoxelIndex end_cell = last / (1 << shift);
    for (Walk walk(from, to, shift);; walk.step()) {
      const VoxelIndex voxel = walk.cell() * (1 << shift);
      if (inside(voxel) && walk.cell() != end_cell) {
        tile.miss(CellKey::of_voxel(Grid::in_tile(voxel), free_depth), model);
      }
      if (walk.remaining() == 0) break;
    }
  }
  if (ray.hit && inside(last)) tile.hit(CellKey::of_voxel(Grid::in_tile(last), kDepth), model);
}

/// Every tile takes its rays; tiles are shared out among threads.
double empty(Queues& queues, int free_depth, std::size_t threads, Tiles& tiles) {
  double bytes = 0;
  std::vector<std::pair<const TileKey, std::vector<QueuedRay>>*> work;
  for (auto& queue : queues) {
    tiles.try_emplace(queue.first);
    bytes += static_cast<double>(queue.second.capacity() * sizeof(QueuedRay));
    work.push_back(&queue);
  }
  std::atomic<std::size_t> next{0};
  const auto take = [&] {
    for (std::size_t i = next++; i < work.size(); i = next++) {
      auto& [key, rays] = *work[i];
      TileTree& tile = tiles.at(key);
      for (const QueuedRay& ray : rays) update(key, ray, free_depth, tile);
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(take);
    take();
  }
  queues.clear();
  return bytes;
}

}  // namespace

StrategyCost ray_based(const std::vector<Scan>& scans, const IntegrationParameters& how) {
  const double before = resident_bytes(), began = wall_seconds();
  Tiles tiles;
  Integrator integrator(Grid::standard(), how);
  for (const auto& scan : scans) {
    const auto delta = *integrator.integrate(scan);
    for (const auto& [key, change] : delta.tiles) tiles[key].apply(change, SensorModel::standard());
  }
  for (auto& [key, tile] : tiles) tile.prune();
  return cost_of(tiles, began, before, 0);
}

StrategyCost tile_based(const std::vector<Scan>& scans, const IntegrationParameters& how,
                        std::size_t at_once, std::size_t threads) {
  const double before = resident_bytes(), began = wall_seconds();
  Tiles tiles;
  Queues queues;
  double queued = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const int depth = integration_depth(scans[i].sigma, Grid::standard().tile_length()).value();
    VOX_CHECK(depth == kDepth);  // The bench's scans are this exact.
    enqueue(scans[i], how, queues);
    if ((i + 1) % at_once == 0 || i + 1 == scans.size()) {
      queued = std::max(queued, empty(queues, how.free_depth, threads, tiles));
    }
  }
  for (auto& [key, tile] : tiles) tile.prune();
  return cost_of(tiles, began, before, queued);
}

}  // namespace voxatlas::bench
