#include "store/store_copy.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "store/memory_store.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr ShardId kShard = 3;
const std::vector<std::string> kNames = {"parameters", "never written"};

Status go_on(std::uint64_t) { return {}; }

Bytes random_bytes(std::mt19937_64& rng, std::size_t most) {
  Bytes bytes(std::uniform_int_distribution<std::size_t>(1, most)(rng));
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
  return bytes;
}

StoredTile random_tile(std::mt19937_64& rng, std::uint64_t code) {
  StoredTile tile{TileKey::from_morton(code).value(), 1 + rng() % 9, {}};
  if (rng() % 8 != 0) tile.bytes = random_bytes(rng, 200);  // Else a tombstone.
  return tile;
}

/// Some pages of tiles, a trimmed journal, marks and a value.
void fill(TileStore& store) {
  auto rng = test::engine();
  const auto epoch = store.acquire(kShard).value();
  std::vector<StoredTile> tiles;
  for (std::uint64_t i = 0; i < 700; ++i) tiles.push_back(random_tile(rng, i * i * 977));
  REQUIRE(store.put(kShard, epoch, tiles));
  std::vector<Bytes> records;
  for (int i = 0; i < 40; ++i) records.push_back(random_bytes(rng, 3'000));
  REQUIRE(store.append(kShard, epoch, records));
  const Mark marks[] = {{"car", 7, 40}, {"tram", -3, 0}};
  REQUIRE(store.trim(kShard, epoch, 13, marks));
  REQUIRE(store.put_value(kShard, epoch, "parameters", random_bytes(rng, 50)));
}

/// Oracle: everything a shard says of itself, one after the other.
std::vector<Bytes> all_of(TileStore& store) {
  std::vector<Bytes> all;
  const auto tiles = store.scan(kShard, TileKey::from_morton(0).value(), 1'000'000).value();
  for (const auto& tile : tiles) {
    Bytes head;
    ByteWriter(head).put(tile.key.morton());
    ByteWriter(head).put(tile.version);
    all.push_back(head);
    all.push_back(tile.bytes);
  }
  REQUIRE(store.replay(kShard, [&](JournalPosition, ByteView record) -> Status {
    all.emplace_back(record.begin(), record.end());
    return {};
  }));
  const auto marks = store.marks(kShard).value();
  for (const auto& mark : marks) {
    Bytes bytes(mark.source.begin(), mark.source.end());
    ByteWriter(bytes).put(mark.session);
    ByteWriter(bytes).put(mark.seq);
    all.push_back(bytes);
  }
  for (const auto& name : kNames) {
    all.push_back(store.value(kShard, name).value().value_or(Bytes()));
  }
  return all;
}

TEST_CASE("a copy holds what its model does", "[store][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  MemoryStore from, to;
  fill(from);
  const auto epoch = to.acquire(kShard).value();

  const auto copied = copy_shard(from, to, kShard, epoch, kNames, go_on);

  REQUIRE(copied.has_value());
  CHECK(copied->tiles == 700);
  CHECK(copied->written == 700);
  CHECK(copied->records == 27);
  CHECK(all_of(to) == all_of(from));
}

TEST_CASE("a copy that failed anywhere goes on and writes only what is missing", "[store]") {
  INFO("VOX_SEED=" << test::seed());
  MemoryStore from;
  fill(from);
  for (int failing = 0; failing < 100; ++failing) {
    const bool applied = failing % 2 == 0;
    CAPTURE(failing, applied);
    MemoryStore to;
    const auto epoch = to.acquire(kShard).value();
    int call = 0;
    to.inject([&](StoreCall) -> std::optional<StoreFault> {
      if (call++ != failing) return std::nullopt;
      return StoreFault{ErrorCode::kUnknown, applied};
    });
    const auto first = copy_shard(from, to, kShard, epoch, kNames, go_on);
    to.inject({});
    const auto there = to.scan(kShard, TileKey::from_morton(0).value(), 1'000'000).value().size();

    const auto second = copy_shard(from, to, kShard, epoch, kNames, go_on);

    REQUIRE(second.has_value());
    REQUIRE(second->written == 700 - there);
    REQUIRE(all_of(to) == all_of(from));
    if (first) return;  // Every call has failed once.
  }
  FAIL("a copy takes more calls than were failed");
}

TEST_CASE("a shard's digest tells every kind of difference", "[store]") {
  MemoryStore one;
  fill(one);
  const auto digest = [](TileStore& store) {
    return shard_content(store, kShard, kNames, go_on).value().digest;
  };
  const auto change = GENERATE(0, 1, 2, 3);
  MemoryStore other;
  const auto epoch = other.acquire(kShard).value();
  REQUIRE(copy_shard(one, other, kShard, epoch, kNames, go_on));
  REQUIRE(digest(one) == digest(other));
  if (change == 0) {
    auto tile = other.scan(kShard, TileKey::from_morton(0).value(), 1).value().front();
    ++tile.version;
    REQUIRE(other.put(kShard, epoch, {&tile, 1}));
  } else if (change == 1) {
    const Bytes record = {1};
    REQUIRE(other.append(kShard, epoch, {&record, 1}));
  } else if (change == 2) {
    const Mark mark{"car", 7, 41};
    REQUIRE(other.trim(kShard, epoch, 0, {&mark, 1}));
  } else {
    REQUIRE(other.put_value(kShard, epoch, "never written", Bytes{1}));
  }
  CHECK(digest(one) != digest(other));
}

TEST_CASE("a copy of something else is refused, and stops when it is told to", "[store]") {
  MemoryStore from, to;
  fill(from);
  const auto epoch = to.acquire(kShard).value();
  auto newer = from.scan(kShard, TileKey::from_morton(0).value(), 1).value().front();
  ++newer.version;
  REQUIRE(to.put(kShard, epoch, {&newer, 1}));
  const auto refused = copy_shard(from, to, kShard, epoch, kNames, go_on);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::kInvalid);

  MemoryStore other;
  const auto stop = [](std::uint64_t tiles) -> Status {
    if (tiles == 0) return {};
    return fail(ErrorCode::kUnavailable, "stopped");
  };
  const auto stopped = copy_shard(from, other, kShard, other.acquire(kShard).value(), kNames, stop);
  REQUIRE_FALSE(stopped.has_value());
  CHECK(stopped.error().code == ErrorCode::kUnavailable);
}

TEST_CASE("an unfinished copy says so until it is told that it is whole", "[store]") {
  MemoryStore store;
  const auto epoch = store.acquire(kShard).value();
  CHECK_FALSE(is_unfinished(store, kShard).value());
  REQUIRE(mark_unfinished(store, kShard, epoch, true));
  CHECK(is_unfinished(store, kShard).value());
  REQUIRE(mark_unfinished(store, kShard, epoch, false));
  CHECK_FALSE(is_unfinished(store, kShard).value());
}

}  // namespace
}  // namespace voxatlas
