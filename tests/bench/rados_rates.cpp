// A store in a Ceph cluster against librados itself: the same batches, in turns.
//
//   rados_rates CONF POOL   ->   lines "name ratio ours/s raw/s"
//
// Raw writes the same rows to objects of its own, one omap operation a region, all of a batch under
// way at once, and compares no epoch, seals nothing and keeps no list; it reads them likewise.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <rados/librados.hpp>
#include <random>
#include <set>
#include <vector>

#include "base/utime.hpp"
#include "bench/store_case.hpp"
#include "grid/region_key.hpp"
#include "store/rados_store.hpp"

namespace voxatlas::bench {
namespace {

constexpr std::size_t kTilesABatch = 32, kBatchesASlice = 8;
constexpr int kSlices = 20;

using Rows = std::map<std::string, librados::bufferlist>;

void check(int code, const char* what) {
  if (code < 0) throw std::runtime_error(fmt::format("{}: {}", what, code));
}

std::string raw_key(TileKey key) { return fmt::format("{:016x}", key.morton()); }

std::string raw_object(TileKey key) { return fmt::format("raw-{:016x}", RegionKey::of(key).code); }

/// Operations under way; wait() ends them all.
class Batch {
 public:
  ~Batch() { end(); }
  librados::AioCompletion* next() {
    return under_way_.emplace_back(librados::Rados::aio_create_completion());
  }
  void wait() { check(end(), "an operation of librados"); }

 private:
  int end() {
    int worst = 0;
    for (auto* one : under_way_) {
      one->wait_for_complete();
      worst = std::min(worst, one->get_return_value());
      one->release();
    }
    under_way_.clear();
    return worst;
  }
  std::vector<librados::AioCompletion*> under_way_;
};

void put_raw(librados::IoCtx& pool, std::span<const StoredTile> tiles) {
  std::map<std::string, Rows> objects;
  for (const auto& tile : tiles) {
    auto& value = objects[raw_object(tile.key)][raw_key(tile.key)];
    value.append(reinterpret_cast<const char*>(tile.bytes.data()),
                 static_cast<unsigned>(tile.bytes.size()));
  }
  std::deque<librados::ObjectWriteOperation> operations;
  Batch batch;
  for (const auto& [object, rows] : objects) {
    auto& operation = operations.emplace_back();
    operation.omap_set(rows);
    check(pool.aio_operate(object, batch.next(), &operation), "aio_operate");
  }
  batch.wait();
}

void get_raw(librados::IoCtx& pool, std::span<const StoredTile> tiles) {
  std::map<std::string, std::set<std::string>> objects;
  for (const auto& tile : tiles) objects[raw_object(tile.key)].insert(raw_key(tile.key));
  std::deque<librados::ObjectReadOperation> operations;
  std::deque<Rows> found;
  std::deque<int> codes;
  std::size_t rows = 0;
  {
    Batch batch;
    for (const auto& [object, keys] : objects) {
      auto& operation = operations.emplace_back();
      operation.omap_get_vals_by_keys(keys, &found.emplace_back(), &codes.emplace_back());
      check(pool.aio_operate(object, batch.next(), &operation, nullptr), "aio_operate");
    }
    batch.wait();
  }
  for (const auto& some : found) rows += some.size();
  if (rows != tiles.size()) throw std::runtime_error("rows are missing");
}

void get_ours(TileStore& store, std::span<const StoredTile> tiles) {
  std::vector<TileKey> keys;
  for (const auto& tile : tiles) keys.push_back(tile.key);
  const auto found = or_throw(store.multi_get(0, keys));
  for (const auto& tile : found) {
    if (!tile) throw std::runtime_error("a tile is missing");
  }
}

/// Batches of neighbours, in no order, of 2 to 10 kB that nothing can compress.
std::vector<StoredTile> random_tiles() {
  std::mt19937_64 rng(5);
  std::vector<std::uint64_t> firsts(std::size_t{kSlices} * kBatchesASlice);
  for (std::size_t i = 0; i < firsts.size(); ++i) firsts[i] = i * kTilesABatch + 16;
  std::shuffle(firsts.begin(), firsts.end(), rng);
  std::vector<StoredTile> tiles;
  for (const auto first : firsts) {
    for (std::uint64_t i = 0; i < kTilesABatch; ++i) {
      Bytes bytes(2000 + rng() % 8000);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
      tiles.push_back({TileKey::from_morton(first + i).value(), 1, std::move(bytes)});
    }
  }
  return tiles;
}

using Work = std::function<void(std::span<const StoredTile>)>;

double seconds_of(const Work& work, std::span<const StoredTile> slice) {
  const auto start = steady_utime();
  for (std::size_t at = 0; at < slice.size(); at += kTilesABatch) {
    work(slice.subspan(at, kTilesABatch));
  }
  return static_cast<double>(steady_utime() - start) / 1e6;
}

/// The median of the slices' ratios; who comes first changes.
void take_turns(const char* name, std::span<const StoredTile> tiles, const Work& ours,
                const Work& raw) {
  std::vector<double> ratios;
  double ours_s = 0, raw_s = 0;
  const std::size_t each = kBatchesASlice * kTilesABatch;
  for (std::size_t slice = 0; slice < kSlices; ++slice) {
    const auto some = tiles.subspan(slice * each, each);
    double mine = 0;
    if (slice % 2 == 0) mine = seconds_of(ours, some);
    const double theirs = seconds_of(raw, some);
    if (slice % 2 != 0) mine = seconds_of(ours, some);
    ratios.push_back(theirs / mine);
    ours_s += mine;
    raw_s += theirs;
  }
  std::sort(ratios.begin(), ratios.end());
  const auto all = static_cast<double>(tiles.size());
  fmt::print("{} {:.4g} {:.5g} {:.5g}\n", name, ratios[ratios.size() / 2], all / ours_s,
             all / raw_s);
}

void run(const std::string& conf, const std::string& pool_name) {
  RadosOptions options;
  options.conf = conf;
  options.pool = pool_name;
  options.model = "bench";
  const auto store = or_throw(RadosStore::open(options));
  const auto epoch = or_throw(store->acquire(0));
  librados::Rados cluster;
  librados::IoCtx pool;
  check(cluster.init2("client.admin", "ceph", 0), "init");
  check(cluster.conf_read_file(conf.c_str()), "conf");
  check(cluster.connect(), "connect");
  check(cluster.ioctx_create(pool_name.c_str(), pool), "pool");
  pool.set_namespace("bench-raw");
  const auto tiles = random_tiles();
  const Work put = [&](auto some) { or_throw(store->put(0, epoch, some)); };
  take_turns("rados_first_commit_vs_raw", tiles, put, [&](auto some) { put_raw(pool, some); });
  take_turns("rados_commit_vs_raw", tiles, put, [&](auto some) { put_raw(pool, some); });
  take_turns(
      "rados_get_vs_raw", tiles, [&](auto some) { get_ours(*store, some); },
      [&](auto some) { get_raw(pool, some); });
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "rados_rates CONF POOL\n");
    return 2;
  }
  try {
    voxatlas::bench::run(argv[1], argv[2]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "rados_rates: {}\n", e.what());
    return 1;
  }
}
