// What finding a tile costs, against how many there are: a store on disk, filled with simulated
// keys in patches all over the Earth, a thousand tiles a patch.
//
// Prints lines `TILES_what value unit`: medians of single lookups at random keys, of the store
// alone and of the atlas above it, which decodes the tile; of tiles the atlas has in its cache; and
// of keys never written. Before each the operating system may have cached the files: what is
// measured is the index, not the disk.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>

#include "atlas/atlas.hpp"
#include "base/check.hpp"
#include "bench/import_case.hpp"
#include "bench/render_model.hpp"
#include "codec/tile_codec.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas::bench {
namespace {

constexpr std::size_t kPatchSide = 32, kPatch = kPatchSide * kPatchSide;
constexpr std::size_t kBatch = 20'000, kLookups = 2'000;
constexpr double kEarthRadius = 6'371'000;
constexpr std::size_t kCacheBytes = std::size_t{256} << 20;

/// Tile number i: the patches lie anywhere on a sphere, a patch is 32 x 32 tiles of its plane.
TileKey key_of(std::size_t i) {
  std::mt19937_64 place(i / kPatch);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d way(normal(place), normal(place), normal(place));
  const Eigen::Vector3d middle = way.normalized() * kEarthRadius;
  const auto x = static_cast<double>(i % kPatchSide);
  const auto y = static_cast<double>(i / kPatchSide % kPatchSide);
  const Grid grid = Grid::standard();
  return or_throw(grid.tile_at(middle + grid.tile_length() * Eigen::Vector3d(x, y, 0)));
}

/// Something that decodes: a bit of ground with air above it.
Bytes some_tile() {
  TileTree tile;
  for (std::uint32_t x = 0; x < kTileVoxels; x += 4) {
    tile.hit(CellKey::of_voxel({x, x / 2, 20}, kDepth), SensorModel::standard());
  }
  tile.miss(CellKey::of_voxel({0, 0, 64}, 1), SensorModel::standard());
  return encode_tile(tile, {});
}

double median_us(const std::vector<TileKey>& keys, const std::function<void(TileKey)>& look) {
  std::vector<double> times;
  for (const TileKey key : keys) {
    const double start = wall_seconds();
    look(key);
    times.push_back(1e6 * (wall_seconds() - start));
  }
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                   times.end());
  return times[times.size() / 2];
}

void measure(TileStore& store, Atlas& atlas, std::size_t tiles) {
  std::mt19937_64 engine(tiles);
  std::uniform_int_distribution<std::size_t> any(0, tiles - 1);
  std::vector<TileKey> keys, absent;
  for (std::size_t i = 0; i < kLookups; ++i) keys.push_back(key_of(any(engine)));
  for (std::size_t i = 0; i < kLookups; ++i) absent.push_back(key_of((1u << 30) + any(engine)));
  const auto line = [&](const char* what, double us) {
    fmt::print("{}_{} {:.4g} us\n", tiles, what, us);
  };
  const auto in_atlas = [&](TileKey key) { VOX_CHECK(or_throw(atlas.tile(key)).tree != nullptr); };
  line("store", median_us(keys, [&](TileKey key) { VOX_CHECK(or_throw(store.get(0, key))); }));
  line("atlas", median_us(keys, in_atlas));
  const std::vector<TileKey> few(keys.end() - 200, keys.end());
  line("atlas_cached", median_us(few, in_atlas));
  line("absent", median_us(absent, [&](TileKey key) { (void)or_throw(store.get(0, key)); }));
  fmt::print("{0}_disk {1} bytes\n{0}_resident {2:.6g} bytes\n", tiles,
             or_throw(store.disk_bytes()), resident_bytes());
  std::fflush(stdout);
}

void run(const std::string& folder, std::size_t most) {
  const auto store = or_throw(RocksDbStore::open(folder));
  AtlasOptions options;
  options.cache_bytes = kCacheBytes;
  const auto atlas = or_throw(Atlas::open(*store, 0, ModelParameters{}, options));
  const Bytes bytes = some_tile();
  fmt::print("tile_bytes {} bytes\n", bytes.size());
  std::size_t tiles = 0, next = 10'000;
  while (tiles < most) {
    std::vector<StoredTile> batch;
    for (std::size_t i = 0; i < kBatch && tiles < next; ++i) {
      batch.push_back({key_of(tiles++), 1, bytes});
    }
    or_throw(store->put(0, atlas->epoch(), batch));
    if (tiles < next) continue;
    measure(*store, *atlas, tiles);
    next = std::min(next * 10, std::max(most, next + 1));
  }
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  std::size_t tiles = 1'000'000;
  CLI::App app{"What finding a tile costs, against how many there are"};
  app.add_option("--tiles", tiles,
                 "at most so many: 10 000, then ten times as many again and again")
      ->capture_default_str()
      ->check(CLI::Range(10'000, 100'000'000));
  CLI11_PARSE(app, argc, argv);
  auto folder = (std::filesystem::temp_directory_path() / "voxatlas-lookup-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    fmt::print(stderr, "bench_lookup: no folder {}\n", folder);
    return 1;
  }
  int exit_code = 0;
  try {
    voxatlas::bench::run(folder, tiles);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_lookup: {}\n", e.what());
    exit_code = 1;
  }
  std::filesystem::remove_all(folder);
  return exit_code;
}
