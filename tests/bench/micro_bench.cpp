// bench_micro: the steps of an import one by one, on one thread, by google-benchmark.
//
// A scan of the simulated drive at 10 cm, its rays cut at 100 m: marking, folding into deltas, both
// together with all around them (also for free space at 80 cm and for surface only), the deltas'
// bytes, updating tiles that know the street already, pruning them.
#include <benchmark/benchmark.h>

#include <map>

#include "base/check.hpp"
#include "bench/import_scans.hpp"
#include "integrate/carve.hpp"
#include "integrate/colour_means.hpp"
#include "integrate/fold.hpp"
#include "integrate/integrator.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::bench {
namespace {

constexpr IntegrationParameters kCarve{kDepth, kDepth, 0, 100};
constexpr std::uint32_t kReach = 64;  ///< Tiles: more than 200 m.

using Tiles = std::map<TileKey, TileTree>;

const std::vector<Scan>& scans() {
  static const std::vector<Scan> made = [] {
    auto simulated = simulated_scans(8);
    VOX_CHECK(simulated.has_value());
    return *simulated;
  }();
  return made;
}

const Scan& scan() { return scans().back(); }

const ScanDelta& delta() {
  static const ScanDelta made = *Integrator(Grid::standard(), kCarve).integrate(scan());
  return made;
}

Tiles known_street() {
  Tiles tiles;
  Integrator integrator(Grid::standard(), kCarve);
  for (const auto& each : scans()) {
    const auto made = *integrator.integrate(each);
    for (const auto& [key, change] : made.tiles) tiles[key].apply(change, SensorModel::standard());
  }
  return tiles;
}

struct MarkedScan {
  Marks misses, hits;

  void mark() {
    const auto grid = Grid::standard();
    misses.reset(kDepth, kReach);
    hits.reset(kDepth, kReach);
    const Eigen::Vector3d origin = grid.to_voxels(scan().origin_ecef);
    for (const auto& end : scan().endpoints_ecef) {
      carve(origin, grid.to_voxels(end), misses);
      set_mark(hits, grid.voxel_unchecked(end));
    }
    misses.merge();
  }
};

void count_rays(benchmark::State& state) {
  state.counters["rays"] = benchmark::Counter(static_cast<double>(scan().endpoints_ecef.size()),
                                              benchmark::Counter::kIsIterationInvariantRate);
}

void marks(benchmark::State& state) {
  MarkedScan marked;
  for (auto _ : state) marked.mark();
  count_rays(state);
}
BENCHMARK(marks)->Unit(benchmark::kMillisecond);

void fold_marks(benchmark::State& state) {
  MarkedScan marked;
  for (auto _ : state) {
    state.PauseTiming();  // Folding uses the misses up.
    marked.mark();
    state.ResumeTiming();
    benchmark::DoNotOptimize(fold(marked.misses, marked.hits, {}));
  }
  count_rays(state);
}
BENCHMARK(fold_marks)->Name("fold")->Unit(benchmark::kMillisecond);

void update(benchmark::State& state) {
  auto tiles = known_street();
  const auto model = SensorModel::standard();
  for (auto _ : state) {
    for (const auto& [key, change] : delta().tiles) tiles[key].apply(change, model);
  }
  count_rays(state);
}
BENCHMARK(update)->Unit(benchmark::kMillisecond);

void prune(benchmark::State& state) {
  const auto street = known_street();
  for (auto _ : state) {
    state.PauseTiming();
    auto tiles = street;
    state.ResumeTiming();
    for (auto& [key, tile] : tiles) tile.prune();
  }
}
BENCHMARK(prune)->Unit(benchmark::kMillisecond);

void integrate(benchmark::State& state, int free_depth) {
  Integrator integrator(Grid::standard(), {free_depth, kDepth, 0, 100});
  for (auto _ : state) benchmark::DoNotOptimize(integrator.integrate(scan()));
  count_rays(state);
}
BENCHMARK_CAPTURE(integrate, carve, kDepth)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrate, free80, kBrickDepth)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrate, surface, IntegrationParameters::kNoFreeSpace)
    ->Unit(benchmark::kMillisecond);

/// Bytes of the masks of a scan's deltas, 64 a brick.
std::int64_t mask_bytes() {
  std::size_t masks = 0;
  for (const auto& [key, change] : delta().tiles) {
    masks += change.misses.bricks.size() + change.hits.bricks.size();
  }
  return static_cast<std::int64_t>(masks * sizeof(BrickBits));
}

void encode(benchmark::State& state) {
  Bytes bytes;
  for (auto _ : state) {
    bytes.clear();
    for (const auto& [key, change] : delta().tiles) encode_delta(change, bytes);
    benchmark::DoNotOptimize(bytes.data());
  }
  state.SetBytesProcessed(mask_bytes() * state.iterations());
  state.counters["wire_bytes"] = static_cast<double>(bytes.size());
}
BENCHMARK(encode)->Unit(benchmark::kMillisecond);

void decode(benchmark::State& state) {
  std::vector<Bytes> encoded;
  for (const auto& [key, change] : delta().tiles) encode_delta(change, encoded.emplace_back());
  for (auto _ : state) {
    for (const auto& bytes : encoded) benchmark::DoNotOptimize(decode_delta(bytes));
  }
  state.SetBytesProcessed(mask_bytes() * state.iterations());
}
BENCHMARK(decode)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace voxatlas::bench

BENCHMARK_MAIN();
