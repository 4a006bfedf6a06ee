// Random commits, flushes, faults and crashes: the atlas knows what plain maps know.
#include <catch2/catch.hpp>

#include "atlas_world.hpp"
#include "codec/tile_codec.hpp"
#include "store/memory_store.hpp"
#include "store/rocksdb_store.hpp"
#include "support/engine.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kTiles = 40;

/// So little memory and journal that both are always short.
AtlasOptions tight() {
  AtlasOptions options;
  options.cache_bytes = std::size_t{1} << 20;
  options.journal_max_bytes = 20'000;
  options.rest_seconds = 0;
  return options;
}

/// An atlas, its oracle, and what can happen to them.
class Schedule {
 public:
  Schedule(TileStore& store, std::mt19937_64& rng)
      : store_(&store), rng_(rng), world_(rng(), kTiles) {
    reopen();
  }

  void reopen() {
    atlas_.reset();
    auto opened = Atlas::open(*store_, 0, ModelParameters{}, tight());
    if (!opened) FAIL(opened.error().message);
    atlas_ = std::move(*opened);
  }

  /// The same over another opening of the same bytes.
  void reopen(TileStore& store) {
    store_ = &store;
    reopen();
  }
  void close() { atlas_.reset(); }

  /// One to four scans of two sources, some of them old ones; nothing may be reported but the new.
  /// `trouble` is called before every try but the last; a failed commit is tried again as it is.
  void commit(const std::function<void(int)>& trouble = [](int) {}) {
    std::vector<ShardScan> scans;
    std::vector<TileChange> expected;
    for (auto count = 1 + rng_() % 4; count > 0; --count) {
      const std::string source(1, "ab"[rng_() % 2]);
      if (rng_() % 5 == 0 && world_.mark(source, 1) >= 0) {
        scans.push_back(world_.next_scan(source, 1, -1));  // A duplicate, with other bytes.
        continue;
      }
      scans.push_back(world_.next_scan(source, 1));
      const auto changes = world_.add(scans.back());
      expected.insert(expected.end(), changes.begin(), changes.end());
    }
    std::vector<TileChange> told;  // By all tries: each change once, whichever of them failed.
    for (int attempt = 0; attempt < 20; ++attempt) {
      trouble(attempt);
      const auto done =
          atlas_->commit(scans, [&](const TileChange& change) { told.push_back(change); });
      if (!done) continue;
      REQUIRE(test::same(told, expected));
      return;
    }
    FAIL("twenty commits in vain");
  }

  void refused_commit() {
    const auto scan = world_.next_scan("a", 1, 1 + static_cast<std::int64_t>(rng_() % 3));
    REQUIRE(atlas_->commit({&scan, 1}).error().code == ErrorCode::kInvalid);
  }

  void flush() {
    REQUIRE((rng_() % 4 == 0 ? atlas_->flush() : atlas_->flush_some(1 + rng_() % 9)).has_value());
  }

  /// A compressor's result for some tile, sometimes late, sometimes of another tile.
  void take_encoded() {
    if (world_.tiles.empty()) return;
    auto at = world_.tiles.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(rng_() % world_.tiles.size()));
    EncodedTile encoded{at->first, at->second.version,
                        encode_tile(at->second.tree, {TileCodec::kDense})};
    bool fits = true;
    if (rng_() % 3 == 0) {
      --encoded.version;
      fits = false;
    } else if (rng_() % 3 == 0) {
      auto tree = at->second.tree;
      tree.hit(CellKey{kDepth, 77}, world_.random.model());
      if (!(tree == at->second.tree)) fits = false;
      encoded.bytes = encode_tile(tree, {TileCodec::kDense});
    }
    const auto taken = atlas_->take_encoded(encoded).value();
    REQUIRE(taken.has_value() == fits);
    if (fits) REQUIRE(*taken == encoded.version);
    if (fits) REQUIRE(atlas_->encoded(at->first).value().bytes == encoded.bytes);
  }

  /// A lossy one, sometimes late: a version of its own, from which the tile lives on.
  void take_lossy() {
    if (world_.tiles.empty()) return;
    auto at = world_.tiles.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(rng_() % world_.tiles.size()));
    auto& [tree, version] = at->second;
    const Quantization how{1 + static_cast<int>(rng_() % 8), 3};
    const EncodedTile encoded{at->first, version - rng_() % 2,
                              encode_tile(tree, {TileCodec::kLossy, 0, how})};
    const auto taken = atlas_->take_encoded(encoded).value();
    REQUIRE(taken.has_value() == (encoded.version == version));
    if (!taken) return;
    auto coarse = quantize(tree, how);
    if (!(coarse == tree)) ++version;
    REQUIRE(*taken == version);
    tree = std::move(coarse);
    REQUIRE(atlas_->encoded(at->first).value().bytes == encoded.bytes);
  }

  void look() {
    const auto at = test::key(rng_() % kTiles);
    const auto tile = atlas_->tile(at).value();
    const auto expected = world_.tiles.find(at);
    REQUIRE((tile.tree == nullptr) == (expected == world_.tiles.end()));
    if (tile.tree == nullptr) {
      REQUIRE(atlas_->encoded(at).error().code == ErrorCode::kNotFound);
      return;
    }
    REQUIRE(*tile.tree == expected->second.tree);
    const auto encoded = atlas_->encoded(at).value();
    REQUIRE(encoded.version == expected->second.version);
    REQUIRE(decode_tile(encoded.bytes).value() == expected->second.tree);
  }

  void check_budgets() {
    const auto stats = atlas_->stats();
    REQUIRE(stats.cached_bytes <= tight().cache_bytes * 3 / 2);
    REQUIRE(stats.journal_bytes <= tight().journal_max_bytes);
  }

  void compare() { REQUIRE(world_.difference(*atlas_) == ""); }

  Atlas& atlas() { return *atlas_; }

 private:
  TileStore* store_;
  std::mt19937_64& rng_;
  test::World world_;
  std::unique_ptr<Atlas> atlas_;
};

void random_step(Schedule& schedule, std::mt19937_64& rng) {
  switch (rng() % 10) {
    case 0:
      return schedule.reopen();
    case 1:
      return schedule.refused_commit();
    case 2:
      return schedule.flush();
    case 3:
      return rng() % 2 == 0 ? schedule.take_encoded() : schedule.take_lossy();
    case 4:
      return schedule.look();
    default:
      return schedule.commit();
  }
}

TEST_CASE("an atlas over a store in memory knows what its oracle knows", "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 12; ++run) {
    MemoryStore store;
    Schedule schedule(store, rng);
    for (int step = 0; step < 120; ++step) {
      random_step(schedule, rng);
      schedule.check_budgets();
      if (step % 20 == 0) schedule.compare();
    }
    schedule.compare();
    schedule.reopen();
    schedule.compare();
  }
}

TEST_CASE("an atlas over RocksDB knows what its oracle knows", "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir folder;
  auto store = RocksDbStore::open(folder / "store").value();
  Schedule schedule(*store, rng);
  for (int step = 0; step < 200; ++step) {
    random_step(schedule, rng);
    if (step % 50 != 49) continue;
    schedule.compare();
    schedule.close();
    store.reset();
    store = RocksDbStore::open(folder / "store").value();
    schedule.reopen(*store);
    schedule.compare();
  }
  REQUIRE(store->verify(0).has_value());
}

/// A fault for every call that comes, with one chance in `odds`.
MemoryStore::FaultHook random_faults(std::mt19937_64& rng, std::uint64_t odds) {
  return [&rng, odds](StoreCall call) -> std::optional<StoreFault> {
    if (rng() % odds != 0) return std::nullopt;
    if (call == StoreCall::kRead) return StoreFault{ErrorCode::kIo, false};
    const ErrorCode codes[] = {ErrorCode::kNoSpace, ErrorCode::kUnknown, ErrorCode::kIo};
    const auto code = codes[rng() % 3];
    return StoreFault{code, code != ErrorCode::kNoSpace && rng() % 2 == 0};
  };
}

TEST_CASE("no fault of the store loses, doubles or hides a change", "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 25; ++run) {
    MemoryStore store;
    Schedule schedule(store, rng);
    const std::uint64_t odds = 2 + rng() % 30;
    for (int step = 0; step < 60; ++step) {
      schedule.commit([&](int attempt) {
        store.inject(attempt < 10 ? random_faults(rng, odds) : MemoryStore::FaultHook());
      });
      if (rng() % 3 == 0) {
        const auto flushed = schedule.atlas().flush_some(5);  // It may fail, but not lose.
        static_cast<void>(flushed);
      }
      store.inject({});
      if (step % 10 == 0) schedule.reopen();
      if (step % 10 == 5) schedule.compare();
    }
    schedule.compare();
    schedule.reopen();
    schedule.compare();
  }
}

TEST_CASE("an append that may have happened is read back, not done twice", "[atlas]") {
  for (const bool applied : {false, true}) {
    MemoryStore store;
    auto atlas = Atlas::open(store, 0, {}, tight()).value();
    test::World world(test::seed(), kTiles);
    ShardScan scan = world.next_scan("a", 1);
    while (scan.deltas.empty()) scan = world.next_scan("a", 1);
    const auto expected = world.add(scan);
    store.inject([&](StoreCall call) -> std::optional<StoreFault> {
      if (call != StoreCall::kAppend) return std::nullopt;
      return StoreFault{ErrorCode::kUnknown, applied};
    });
    const auto first = test::changes_of(*atlas, {&scan, 1});
    REQUIRE(first.has_value() == applied);
    store.inject({});
    const auto second = test::changes_of(*atlas, {&scan, 1}).value();
    REQUIRE(test::same(applied ? *first : second, expected));
    if (applied) REQUIRE(second.empty());
    REQUIRE(world.difference(*atlas) == "");
  }
}

}  // namespace
}  // namespace voxatlas
