// The same rows written by our store and by RocksDB itself, in turns.
#include <rocksdb/db.h>
#include <rocksdb/filter_policy.h>
#include <rocksdb/table.h>
#include <rocksdb/write_batch.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "base/utime.hpp"
#include "bench/store_case.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas::bench {
namespace {

constexpr std::size_t kTilesAPut = 32;
constexpr std::size_t kRecordBytes = 1500;
constexpr int kThreads = 16;

void check(const rocksdb::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

/// RocksDB as the store opens it, with one column family and nothing around it.
std::unique_ptr<rocksdb::DB> open_raw(const std::string& directory, std::size_t buffer_bytes) {
  rocksdb::BlockBasedTableOptions table;
  table.cache_index_and_filter_blocks = true;
  table.filter_policy.reset(rocksdb::NewBloomFilterPolicy(10));
  table.format_version = 5;
  rocksdb::Options options;
  options.create_if_missing = true;
  options.max_total_wal_size = std::size_t{64} << 20;
  options.max_background_jobs = 2;
  options.bytes_per_sync = std::uint64_t{1} << 20;
  options.compression = rocksdb::kNoCompression;
  options.write_buffer_size = buffer_bytes;
  options.level_compaction_dynamic_level_bytes = true;
  options.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
  rocksdb::DB* db = nullptr;
  check(rocksdb::DB::Open(options, directory, &db));
  return std::unique_ptr<rocksdb::DB>(db);
}

/// As the store's own keys: 4 bytes of shard, 8 of number, big endian.
std::string raw_key(std::uint64_t number) {
  std::string key(12, '\0');
  for (std::size_t i = 0; i < 8; ++i) key[11 - i] = static_cast<char>(number >> 8 * i);
  return key;
}

/// Bytes that nothing can compress, 2 to 10 kB: as tiles are.
Bytes random_tile(std::mt19937_64& rng) {
  Bytes bytes(2000 + rng() % 8000);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
  return bytes;
}

std::vector<StoredTile> random_tiles(std::size_t count) {
  std::mt19937_64 rng(5);
  std::vector<StoredTile> tiles;
  for (std::size_t i = 0; i < count; ++i) {
    tiles.push_back({TileKey::from_morton(i * 7919).value(), 1, random_tile(rng)});
  }
  std::shuffle(tiles.begin(), tiles.end(), rng);
  return tiles;
}

void put_raw(rocksdb::DB& db, std::span<const StoredTile> tiles) {
  rocksdb::WriteBatch batch;
  for (const auto& tile : tiles) {
    const rocksdb::Slice value(reinterpret_cast<const char*>(tile.bytes.data()), tile.bytes.size());
    check(batch.Put(raw_key(tile.key.morton()), value));
  }
  rocksdb::WriteOptions synced;
  synced.sync = true;
  check(db.Write(synced, &batch));
}

double seconds_of(const std::function<void()>& work) {
  const std::int64_t start = steady_utime();
  work();
  return static_cast<double>(steady_utime() - start) / 1e6;
}

/// Runs both in turns, the first one changing, and compares slice by slice. `items` a slice.
Comparison take_turns(int slices, double items, const std::function<void(int)>& ours,
                      const std::function<void(int)>& raw) {
  std::vector<double> ratios;
  double ours_s = 0, raw_s = 0;
  for (int slice = 0; slice < slices; ++slice) {
    double mine = 0, theirs = 0;
    if (slice % 2 == 0) mine = seconds_of([&] { ours(slice); });
    theirs = seconds_of([&] { raw(slice); });
    if (slice % 2 != 0) mine = seconds_of([&] { ours(slice); });
    ratios.push_back(theirs / mine);
    ours_s += mine;
    raw_s += theirs;
  }
  std::sort(ratios.begin(), ratios.end());
  const double all = items * slices;
  return {ratios[ratios.size() / 2], all / ours_s, all / raw_s};
}

void on_threads(const std::function<void(int)>& work) {
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  for (auto& thread : threads) thread.join();
}

}  // namespace

Comparison compare_tile_commits(const std::string& directory) {
  constexpr int kSlices = 20;
  constexpr std::size_t kTilesASlice = 8 * kTilesAPut;
  const auto store = or_throw(RocksDbStore::open(directory + "-ours"));
  const auto raw = open_raw(directory + "-raw", std::size_t{16} << 20);
  const auto epoch = or_throw(store->acquire(0));
  const auto tiles = random_tiles(10 * kTilesASlice);
  const auto each_put = [&](int slice,
                            const std::function<void(std::span<const StoredTile>)>& put) {
    const auto begin = static_cast<std::size_t>(slice % 10) * kTilesASlice;
    for (std::size_t at = 0; at < kTilesASlice; at += kTilesAPut) {
      put(std::span(tiles).subspan(begin + at, kTilesAPut));
    }
  };
  return take_turns(
      kSlices, kTilesASlice,
      [&](int slice) { each_put(slice, [&](auto some) { or_throw(store->put(0, epoch, some)); }); },
      [&](int slice) { each_put(slice, [&](auto some) { put_raw(*raw, some); }); });
}

Comparison compare_journal_commits(const std::string& directory) {
  constexpr int kSlices = 16;
  constexpr int kRecordsAThread = 20;
  const auto store = or_throw(RocksDbStore::open(directory + "-ours"));
  const auto raw = open_raw(directory + "-raw", std::size_t{8} << 20);
  const auto epoch = or_throw(store->acquire(0));
  std::mt19937_64 rng(6);
  Bytes record(kRecordBytes);
  for (auto& byte : record) byte = static_cast<std::uint8_t>(rng());
  const auto append = [&](int) {
    for (int i = 0; i < kRecordsAThread; ++i) {
      or_throw(store->append(0, epoch, std::span(&record, 1)));
    }
  };
  const rocksdb::Slice value(reinterpret_cast<const char*>(record.data()), record.size());
  const auto put = [&](int slice, int thread) {
    rocksdb::WriteOptions synced;
    synced.sync = true;
    for (int i = 0; i < kRecordsAThread; ++i) {
      const auto number = (slice * kRecordsAThread + i) * kThreads + thread;
      check(raw->Put(synced, raw_key(static_cast<std::uint64_t>(number)), value));
    }
  };
  return take_turns(
      kSlices, double{kRecordsAThread} * kThreads, [&](int) { on_threads(append); },
      [&](int slice) { on_threads([&](int thread) { put(slice, thread); }); });
}

double space_after_overwriting(const std::string& directory) {
  constexpr std::size_t kTiles = 32'768;  // About 200 MB.
  constexpr std::size_t kBatch = 256;
  auto tiles = random_tiles(kTiles);
  std::uint64_t live = 0;
  for (const auto& tile : tiles) live += tile.bytes.size();
  std::mt19937_64 rng(7);
  auto store = or_throw(RocksDbStore::open(directory));
  const auto epoch = or_throw(store->acquire(0));
  for (std::uint64_t version = 1; version <= 8; ++version) {
    std::shuffle(tiles.begin(), tiles.end(), rng);
    for (std::size_t at = 0; at < kTiles; at += kBatch) {
      const auto some = std::span(tiles).subspan(at, kBatch);
      for (auto& tile : some) tile.version = version;
      or_throw(store->put(0, epoch, some));
    }
  }
  store.reset();  // It rests: nothing is in the log alone.
  store = or_throw(RocksDbStore::open(directory));
  return static_cast<double>(or_throw(store->disk_bytes())) / static_cast<double>(live);
}

}  // namespace voxatlas::bench
