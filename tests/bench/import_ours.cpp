#include <malloc.h>

#include <barrier>
#include <map>
#include <optional>
#include <thread>

#include "bench/import_case.hpp"
#include "grid/region_key.hpp"
#include "octree/tile_delta.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::bench {
namespace {

using Tiles = std::map<TileKey, TileTree>;

std::size_t encoded_bytes(const ScanDelta& scan) {
  Bytes bytes;
  for (const auto& [key, delta] : scan.tiles) encode_delta(delta, bytes);
  return bytes.size();
}

/// Seconds of wall time that `workers` threads take.
double wall_time(const std::vector<Scan>& scans, const IntegrationParameters& how,
                 std::uint32_t workers) {
  const auto model = SensorModel::standard();
  std::vector<Tiles> shards(workers);
  std::vector<std::optional<ScanDelta>> deltas(workers);
  std::barrier step(static_cast<std::ptrdiff_t>(workers));
  const auto work = [&](std::uint32_t me) {
    Integrator integrator(Grid::standard(), how);
    for (std::size_t first = 0; first < scans.size(); first += workers) {
      const bool mine = first + me < scans.size();
      deltas[me].reset();
      if (mine) deltas[me] = *integrator.integrate(scans[first + me]);
      step.arrive_and_wait();
      for (const auto& delta : deltas) {
        if (!delta) continue;
        for (const auto& [key, change] : delta->tiles) {
          if (shard_of(key, workers) == me) shards[me][key].apply(change, model);
        }
      }
      step.arrive_and_wait();
    }
  };
  const double start = wall_seconds();
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t i = 1; i < workers; ++i) threads.emplace_back(work, i);
    work(0);
  }
  return wall_seconds() - start;
}

}  // namespace

ImportTiming import_ours(const std::vector<Scan>& scans, const IntegrationParameters& how) {
  const auto model = SensorModel::standard();
  const double before = resident_bytes();
  Tiles tiles;
  Stopwatch watch;
  double delta_bytes = 0;
  {
    Integrator integrator(Grid::standard(), how);
    for (const auto& scan : scans) {
      watch.start();
      const auto delta = *integrator.integrate(scan);
      for (const auto& [key, change] : delta.tiles) tiles[key].apply(change, model);
      watch.stop(scan.endpoints_ecef.size());
      delta_bytes += static_cast<double>(encoded_bytes(delta));
    }
    watch.start();
    for (auto& [key, tile] : tiles) tile.prune();
  }
  auto timing = watch.finish();
  malloc_trim(0);
  timing.resident_bytes = resident_bytes() - before;
  timing.delta_bytes = delta_bytes;
  return timing;
}

double two_threads_speedup(const std::vector<Scan>& scans, const IntegrationParameters& how) {
  const double one = wall_time(scans, how, 1);
  return one / wall_time(scans, how, 2);
}

}  // namespace voxatlas::bench
