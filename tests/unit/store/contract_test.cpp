// The contract of TileStore, asked of every backend in the same words.
#include <catch2/catch.hpp>
#include <map>
#include <thread>

#include "backends.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }

Bytes random_bytes(std::mt19937_64& rng, std::size_t limit) {
  Bytes bytes(rng() % limit);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
  return bytes;
}

bool same(const StoredTile& a, const StoredTile& b) {
  return a.key == b.key && a.version == b.version && a.bytes == b.bytes;
}

using Journal = std::map<JournalPosition, Bytes>;

Journal journal_of(TileStore& store, ShardId shard) {
  Journal journal;
  const auto status = store.replay(shard, [&](JournalPosition position, ByteView record) -> Status {
    journal.emplace(position, Bytes(record.begin(), record.end()));
    return {};
  });
  REQUIRE(status.has_value());
  return journal;
}

/// Oracle: one shard in standard containers.
struct Model {
  Epoch epoch = 0;
  JournalPosition last = 0;
  Journal journal;
  std::map<TileKey, StoredTile> tiles;
  std::vector<Mark> marks;
  std::map<std::string, Bytes> values;
};

constexpr std::uint64_t kCodes = 40;
constexpr ShardId kShards[] = {0, 7, ~ShardId{0}};

class Run {
 public:
  Run(test::Backend& backend, std::mt19937_64& rng) : backend_(backend), rng_(rng) {
    for (const auto shard : kShards) acquire(shard);
  }

  void step() {
    const ShardId shard = kShards[rng_() % std::size(kShards)];
    switch (rng_() % 16) {
      case 0:
        return acquire(shard);
      case 1:
        return backend_.reopen();
      case 2:
      case 3:
        return trim(shard);
      case 4:
        return put_value(shard);
      case 5:
        return fenced_writes(shard);
      case 6:
      case 7:
      case 8:
      case 9:
        return put(shard);
      default:
        return append(shard);
    }
  }

  void compare() {
    for (const auto shard : kShards) {
      const Model& model = models_[shard];
      REQUIRE(journal_of(store(), shard) == model.journal);
      REQUIRE(store().marks(shard).value() == model.marks);
      for (const char* name : {"a", "b", "c"}) {
        const auto expected = model.values.find(name);
        const auto value = store().value(shard, name).value();
        REQUIRE(value.has_value() == (expected != model.values.end()));
        if (value) REQUIRE(*value == expected->second);
      }
      compare_tiles(shard, model);
      REQUIRE(store().verify(shard).has_value());
    }
  }

 private:
  TileStore& store() { return backend_.store(); }

  void acquire(ShardId shard) {
    const auto epoch = store().acquire(shard);
    REQUIRE(epoch.has_value());
    REQUIRE(*epoch > models_[shard].epoch);
    models_[shard].epoch = *epoch;
  }

  void append(ShardId shard) {
    Model& model = models_[shard];
    std::vector<Bytes> records(rng_() % 4);
    for (auto& record : records) record = random_bytes(rng_, 3000);
    for (const auto& record : records) model.journal.emplace(++model.last, record);
    REQUIRE(store().append(shard, model.epoch, records).value() == model.last);
  }

  void put(ShardId shard) {
    Model& model = models_[shard];
    std::map<TileKey, StoredTile> tiles;
    for (auto count = rng_() % 6; count > 0; --count) {
      const auto at = key(rng_() % kCodes);  // An empty one is a tombstone.
      tiles.insert_or_assign(at, StoredTile{at, rng_(), random_bytes(rng_, 2000)});
    }
    std::vector<StoredTile> list;
    for (const auto& [at, tile] : tiles) list.push_back(tile);
    REQUIRE(store().put(shard, model.epoch, list).has_value());
    for (const auto& tile : list) model.tiles.insert_or_assign(tile.key, tile);
  }

  void trim(ShardId shard) {
    Model& model = models_[shard];
    const auto position = model.last - std::min<JournalPosition>(model.last, rng_() % 8);
    std::vector<Mark> marks(rng_() % 3);
    for (auto& mark : marks) {
      mark = {std::string(rng_() % 20, 's'), static_cast<std::int64_t>(rng_()),
              static_cast<std::int64_t>(rng_() % 100)};
    }
    REQUIRE(store().trim(shard, model.epoch, position, marks).has_value());
    model.journal.erase(model.journal.begin(), model.journal.upper_bound(position));
    model.marks = marks;
  }

  void put_value(ShardId shard) {
    Model& model = models_[shard];
    const std::string name(1, "abc"[rng_() % 3]);
    const Bytes value = random_bytes(rng_, 50);
    REQUIRE(store().put_value(shard, model.epoch, name, value).has_value());
    model.values.insert_or_assign(name, value);
  }

  /// Nothing that an earlier owner, or one that never was, writes may change anything.
  void fenced_writes(ShardId shard) {
    const Epoch epoch = models_[shard].epoch + (rng_() % 2 == 0 ? 1 : ~Epoch{0});
    const std::vector<Bytes> records(1, Bytes{1});
    const std::vector<StoredTile> tiles(1, StoredTile{key(1), 1, {1}});
    REQUIRE(store().append(shard, epoch, records).error().code == ErrorCode::kFenced);
    REQUIRE(store().put(shard, epoch, tiles).error().code == ErrorCode::kFenced);
    REQUIRE(store().trim(shard, epoch, 0, {}).error().code == ErrorCode::kFenced);
    REQUIRE(store().put_value(shard, epoch, "a", {}).error().code == ErrorCode::kFenced);
  }

  void compare_tiles(ShardId shard, const Model& model) {
    std::vector<TileKey> keys;
    for (std::uint64_t code = 0; code <= kCodes; ++code) keys.push_back(key(code));
    std::shuffle(keys.begin(), keys.end(), rng_);
    const auto found = store().multi_get(shard, keys).value();
    REQUIRE(found.size() == keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const auto expected = model.tiles.find(keys[i]);
      REQUIRE(found[i].has_value() == (expected != model.tiles.end()));
      if (found[i]) REQUIRE(same(*found[i], expected->second));
    }
    const auto from = key(rng_() % kCodes);
    const std::size_t limit = 1 + rng_() % kCodes;
    auto expected = model.tiles.lower_bound(from);
    const auto scanned = store().scan(shard, from, limit);
    REQUIRE(scanned.has_value());
    for (const auto& tile : *scanned) {
      REQUIRE(expected != model.tiles.end());
      REQUIRE(same(tile, expected->second));
      ++expected;
    }
    const auto rest = std::distance(model.tiles.lower_bound(from), model.tiles.end());
    REQUIRE(std::distance(model.tiles.lower_bound(from), expected) ==
            std::min<std::ptrdiff_t>(rest, static_cast<std::ptrdiff_t>(limit)));
  }

  test::Backend& backend_;
  std::mt19937_64& rng_;
  std::map<ShardId, Model> models_;
};

TEST_CASE("a store keeps what random calls wrote, across reopening", "[store][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    Run run(*backend, rng);
    for (int round = 0; round < 30; ++round) {
      for (int i = 0; i < 12; ++i) run.step();
      run.compare();
    }
  }
}

TEST_CASE("an empty store answers every question with nothing", "[store]") {
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    TileStore& store = backend->store();
    REQUIRE_FALSE(store.get(3, key(5)).value().has_value());
    REQUIRE(store.scan(3, key(0), 10).value().empty());
    REQUIRE(store.marks(3).value().empty());
    REQUIRE_FALSE(store.value(3, "parameters").value().has_value());
    REQUIRE(journal_of(store, 3).empty());
    REQUIRE(store.verify(3).has_value());
    REQUIRE(store.append(3, 1, {}).error().code == ErrorCode::kFenced);
  }
}

TEST_CASE("a journal's positions go on after everything was trimmed, across reopening", "[store]") {
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    const auto epoch = backend->store().acquire(0).value();
    const std::vector<Bytes> three{{1}, {2}, {3}};
    REQUIRE(backend->store().append(0, epoch, three).value() == 3);
    REQUIRE(backend->store().trim(0, epoch, 3, {}).has_value());
    backend->reopen();
    REQUIRE(backend->store().append(0, epoch, three).value() == 6);
    REQUIRE(backend->store().trim(0, epoch, 7, {}).error().code == ErrorCode::kInvalid);
    REQUIRE(journal_of(backend->store(), 0).begin()->first == 4);
  }
}

TEST_CASE("a visitor's error stops a replay and comes back", "[store]") {
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    TileStore& store = backend->store();
    const auto epoch = store.acquire(0).value();
    REQUIRE(store.append(0, epoch, std::vector<Bytes>(5)).has_value());
    int visited = 0;
    const auto status = store.replay(0, [&](JournalPosition position, ByteView) -> Status {
      ++visited;
      if (position == 3) return fail(ErrorCode::kOutOfRange, "enough");
      return {};
    });
    REQUIRE(status.error().message == "enough");
    REQUIRE(visited == 3);
  }
}

TEST_CASE("a checkpoint opens as a store of its own and stays as it was", "[store]") {
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    TileStore& store = backend->store();
    const auto epoch = store.acquire(2).value();
    const std::vector<StoredTile> before{{key(9), 4, {1, 2, 3}}};
    REQUIRE(store.put(2, epoch, before).has_value());
    REQUIRE(store.append(2, epoch, std::vector<Bytes>{{42}}).has_value());
    REQUIRE(store.checkpoint(backend->path("copy")).has_value());
    REQUIRE_FALSE(store.checkpoint(backend->path("copy")).has_value());
    const std::vector<StoredTile> after{{key(9), 5, {9}}};
    REQUIRE(store.put(2, epoch, after).has_value());

    const auto copy = backend->open_checkpoint(backend->path("copy"));
    REQUIRE(same(copy->get(2, key(9)).value().value(), before[0]));
    REQUIRE(journal_of(*copy, 2) == Journal{{1, {42}}});
    REQUIRE(copy->acquire(2).value() == epoch + 1);
    REQUIRE(same(store.get(2, key(9)).value().value(), after[0]));
    REQUIRE(store.disk_bytes().value() > 0);
  }
}

TEST_CASE("threads that append to several shards lose and mix nothing", "[store]") {
  constexpr int kEach = 40;
  for (auto& backend : test::all_backends()) {
    INFO(backend->name());
    TileStore& store = backend->store();
    std::vector<std::thread> threads;
    std::vector<int> failed(4);
    for (ShardId shard = 0; shard < 2; ++shard) {
      const auto epoch = store.acquire(shard).value();
      for (std::uint8_t who = 0; who < 2; ++who) {
        threads.emplace_back([&store, &failed, shard, epoch, who] {
          for (std::uint8_t i = 0; i < kEach; ++i) {
            const std::vector<Bytes> record{{who, i}};
            if (!store.append(shard, epoch, record)) ++failed[shard * 2 + who];
          }
        });
      }
    }
    for (auto& thread : threads) thread.join();
    REQUIRE(failed == std::vector<int>(4));
    for (ShardId shard = 0; shard < 2; ++shard) {
      std::map<std::uint8_t, std::uint8_t> next;
      const auto journal = journal_of(store, shard);
      REQUIRE(journal.size() == 2 * kEach);
      for (const auto& [position, record] : journal) REQUIRE(record[1] == next[record[0]]++);
    }
  }
}

}  // namespace
}  // namespace voxatlas
