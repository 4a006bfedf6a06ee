// A shard under test, in a process that can be killed: commits scans for ever and says which are
// durable, or checks what another one has left. Every scan follows from its number, so that the
// checker knows what must be there.
//
//   store_probe write DIR [--no-sync] [--ack-ahead N]   prints `A n` when scan n is durable
//   store_probe verify DIR N                            0: scans 0..N are there, each applied once
//   store_probe read-beside DIR                         `A` for each synced append, `R` for each
//                                                       line of standard input, once it has read
//   store_probe fill DIR TILES CACHE_MB                 prints peak memory and a hash of all tiles
//
// --no-sync and --ack-ahead are the controls: with them, tests must see a loss.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <thread>

#include "atlas/memory_plan.hpp"
#include "octree/tile_hash.hpp"
#include "store/rocksdb_store.hpp"
#include "unit/atlas/atlas_world.hpp"

namespace voxatlas {
namespace {

constexpr std::uint64_t kSeed = 11;
constexpr std::uint32_t kTiles = 300;

struct Options {
  std::string directory;
  bool no_sync = false;
  std::int64_t ack_ahead = 0;
  std::int64_t acknowledged = -1;
  std::uint32_t tiles = 0;
  std::size_t cache_mb = 256;
};

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

struct Shard {
  explicit Shard(const Options& options) {
    const auto plan = or_throw(MemoryPlan::of(options.cache_mb << 20));
    RocksDbOptions how;
    how.sync = !options.no_sync;
    how.memory_bytes = std::min(how.memory_bytes, plan.store);
    how.write_buffer_bytes = std::min(how.write_buffer_bytes, plan.write_buffers);
    AtlasOptions limits;
    limits.cache_bytes = plan.tiles;
    limits.journal_max_bytes = std::size_t{4} << 20;
    store = or_throw(RocksDbStore::open(options.directory + "/shard-0", how));
    atlas = or_throw(Atlas::open(*store, 0, ModelParameters{}, limits));
  }
  std::unique_ptr<RocksDbStore> store;
  std::unique_ptr<Atlas> atlas;
};

/// The world after scans 0..last.
test::World world_up_to(std::int64_t last) {
  test::World world(kSeed, kTiles);
  for (std::int64_t n = 0; n <= last; ++n) world.add(world.next_scan("probe", 1));
  return world;
}

void write_scans(const Options& options) {
  Shard shard(options);
  auto world = world_up_to(shard.atlas->mark("probe", 1));
  for (;;) {
    const ShardScan scans[] = {world.next_scan("probe", 1)};
    const auto n = scans[0].seq;
    or_throw(shard.atlas->commit(scans));
    world.add(scans[0]);
    fmt::print("A {}\n", n + options.ack_ahead);
    std::fflush(stdout);
    if (n % 7 == 0) or_throw(shard.atlas->flush_some(8));
  }
}

void verify_scans(const Options& options) {
  Shard shard(options);
  or_throw(shard.store->verify(0));
  const auto mark = shard.atlas->mark("probe", 1);
  if (mark < options.acknowledged) {
    throw std::runtime_error(
        fmt::format("scans up to {} are there, {} was acknowledged", mark, options.acknowledged));
  }
  const auto difference = mark < 0 ? "" : world_up_to(mark).difference(*shard.atlas);
  if (!difference.empty()) throw std::runtime_error(difference);
  fmt::print("scans up to {}\n", mark);
}

/// A thread appends for ever; this one reads when it is told to.
void read_beside(const Options& options) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto store = or_throw(RocksDbStore::open(options.directory + "/shard-0"));
  const auto epoch = or_throw(store->acquire(0));
  const StoredTile tiles[] = {{test::key(1), 1, Bytes(5'000, 7)}};
  or_throw(store->put(0, epoch, tiles));
  std::thread appends([&] {  // Ends with the process.
    const Bytes records[] = {Bytes(1'500, 1)};
    while (store->append(0, epoch, records)) fmt::print("A\n");
  });
  for (std::string line; std::getline(std::cin, line);) {
    const auto tile = or_throw(store->get(0, test::key(1)));
    const auto page = or_throw(store->scan(0, test::key(0), 10));
    if (!tile || page.size() != 1) throw std::runtime_error("the tile is not there");
    fmt::print("R\n");
  }
  std::_Exit(0);
}

/// One of a tile's changes: some free space and a piece of surface.
Bytes change_of(std::uint64_t tile, std::uint64_t pass) {
  TileDelta delta;
  delta.misses.depth = kBrickDepth;
  delta.hits.depth = kDepth;
  test::RandomOctree random(tile * 16 + pass);
  for (int i = 0; i < 12; ++i) delta.misses.insert({kBrickDepth, 64 + random.below(4000)});
  const std::uint32_t brick = 512 * (random.below(60));
  for (int i = 0; i < 40; ++i) delta.hits.insert({kDepth, brick + random.below(2048)});
  return test::delta_bytes(delta);
}

ShardScan scan_of(std::uint32_t tiles, std::int64_t seq) {
  constexpr std::uint32_t kTilesAScan = 250;
  const auto scans_a_pass = static_cast<std::int64_t>((tiles + kTilesAScan - 1) / kTilesAScan);
  const auto pass = static_cast<std::uint64_t>(seq / scans_a_pass);
  const auto first = static_cast<std::uint64_t>(seq % scans_a_pass) * kTilesAScan;
  ShardScan scan{"probe", 1, seq, {}};
  for (auto i = first; i < std::min<std::uint64_t>(first + kTilesAScan, tiles); ++i) {
    scan.deltas.emplace_back(test::key(i * 64), change_of(i, pass));
  }
  return scan;
}

std::string hash_of(Atlas& atlas) {
  Sha256 sum;
  auto from = TileKey::from_morton(0);
  for (;;) {
    const auto page = or_throw(atlas.list(*from, 256));
    for (const auto& info : page) {
      sum.update(tile_hash(info.key, *or_throw(atlas.tile(info.key)).tree));
    }
    if (page.empty()) return to_hex(sum.finish());
    from = TileKey::from_morton(page.back().key.morton() + 1);
  }
}

double peak_resident_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib / 1024;
  }
  throw std::runtime_error("no VmHWM in /proc/self/status");
}

/// Every tile three times over, in passes: each pass finds the tiles of the last one written out.
void fill_tiles(const Options& options) {
  Shard shard(options);
  const std::int64_t scans = 3 * ((options.tiles + 249) / 250);
  for (std::int64_t seq = 0; seq < scans; ++seq) {
    const ShardScan part[] = {scan_of(options.tiles, seq)};
    or_throw(shard.atlas->commit(part));
  }
  const auto hash = hash_of(*shard.atlas);
  fmt::print("peak_mib {:.1f}\ntiles_flushed {}\nhash {}\n", peak_resident_mib(),
             shard.atlas->stats().tiles_flushed, hash);
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  using namespace voxatlas;
  Options options;
  CLI::App app{"a shard under test"};
  app.require_subcommand(1);
  auto* write_mode = app.add_subcommand("write");
  auto* verify_mode = app.add_subcommand("verify");
  auto* read_mode = app.add_subcommand("read-beside");
  auto* fill_mode = app.add_subcommand("fill");
  for (auto* mode : {write_mode, verify_mode, read_mode, fill_mode}) {
    mode->add_option("dir", options.directory)->required();
  }
  write_mode->add_flag("--no-sync", options.no_sync);
  write_mode->add_option("--ack-ahead", options.ack_ahead);
  verify_mode->add_option("acknowledged", options.acknowledged)->required();
  fill_mode->add_option("tiles", options.tiles)->required();
  fill_mode->add_option("cache_mb", options.cache_mb)->required();
  CLI11_PARSE(app, argc, argv);
  if (*fill_mode) options.no_sync = true;  // Of memory and hashes it says the same, sooner.
  try {
    if (*write_mode) write_scans(options);
    if (*verify_mode) verify_scans(options);
    if (*read_mode) read_beside(options);
    if (*fill_mode) fill_tiles(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "store_probe: {}\n", e.what());
    return 1;
  }
}
