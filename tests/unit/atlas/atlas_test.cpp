#include "atlas/atlas.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "atlas_world.hpp"
#include "codec/tile_codec.hpp"
#include "grid/region_key.hpp"
#include "store/memory_store.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using test::key;

std::unique_ptr<Atlas> open_atlas(TileStore& store, const AtlasOptions& options = {},
                                  const ModelParameters& parameters = {}, ShardId shard = 0) {
  auto atlas = Atlas::open(store, shard, parameters, options);
  if (!atlas) FAIL(atlas.error().message);
  return std::move(*atlas);
}

/// A scan whose every delta hits one voxel.
ShardScan small_scan(std::int64_t seq, const std::vector<TileKey>& keys) {
  TileDelta delta;
  delta.hits.insert(CellKey{kDepth, 4711});
  ShardScan scan{"car", 1, seq, {}};
  for (const auto at : keys) scan.deltas.emplace_back(at, test::delta_bytes(delta));
  return scan;
}

TEST_CASE("thousands of tiles pass through a small cache, and none is lost", "[atlas]") {
  AtlasOptions options;
  options.cache_bytes = std::size_t{1} << 20;
  options.journal_max_bytes = std::size_t{100} << 10;
  MemoryStore store;
  auto atlas = open_atlas(store, options);
  constexpr std::uint64_t kTiles = 3000;
  std::int64_t seq = 0;
  for (int round = 0; round < 2; ++round) {
    for (std::uint64_t first = 0; first < kTiles; first += 250) {
      std::vector<TileKey> keys;  // More than the cache holds, in one scan.
      for (std::uint64_t code = first; code < first + 250; ++code) keys.push_back(key(code));
      const auto scan = small_scan(seq++, keys);
      REQUIRE(test::changes_of(*atlas, {&scan, 1}).value().size() == 250);
      REQUIRE(atlas->stats().cached_bytes <= options.cache_bytes);
      REQUIRE(atlas->stats().journal_bytes <= options.journal_max_bytes);
    }
  }
  REQUIRE(atlas->stats().cached_tiles < 200);
  REQUIRE(atlas->list(key(0), 10'000).value().size() == kTiles);
  for (std::uint64_t code = 0; code < kTiles; code += 7) {
    const auto tile = atlas->tile(key(code)).value();
    REQUIRE(tile.version == 2);
    REQUIRE(tile.tree->counts().occupied_voxels == 1);
    REQUIRE(atlas->stats().cached_bytes <= options.cache_bytes);
  }
}

TEST_CASE("reading writes nothing and waits for no write, whatever is dirty", "[atlas]") {
  MemoryStore store;
  std::vector<TileKey> old, dirty;
  for (std::uint64_t code = 0; code < 400; ++code) (code < 200 ? old : dirty).push_back(key(code));
  {
    const auto before = open_atlas(store);
    const auto scan = small_scan(0, old);
    REQUIRE(before->commit({&scan, 1}).has_value());
    REQUIRE(before->flush().has_value());
  }
  const auto atlas = open_atlas(store);
  const auto scan = small_scan(1, dirty);
  REQUIRE(atlas->commit({&scan, 1}).has_value());
  atlas->limit_cache(1 << 10);  // Far below what is dirty: the next commit must write.
  int writes = 0;
  store.inject([&](StoreCall call) -> std::optional<StoreFault> {
    if (call == StoreCall::kRead) return std::nullopt;
    ++writes;
    return StoreFault{ErrorCode::kNoSpace, false};
  });
  for (const auto& keys : {old, dirty}) {
    for (const auto at : keys) REQUIRE(atlas->tile(at).value().version == 1);
    for (const auto at : keys) REQUIRE(atlas->encoded(at).value().version == 1);
  }
  REQUIRE(atlas->list(key(0), 1'000).value().size() == 400);
  REQUIRE(writes == 0);
  const auto next = small_scan(2, {key(1)});
  REQUIRE(atlas->commit({&next, 1}).error().code == ErrorCode::kNoSpace);  // The control.
  REQUIRE(writes == 1);
}

TEST_CASE("a journal that is kept holds every record, and the shard opens as it was", "[atlas]") {
  AtlasOptions options;
  options.keep_journal = true;
  options.journal_max_bytes = 10'000;  // Tiles are flushed on the way.
  MemoryStore store;
  auto world = test::World(5, 30);
  auto atlas = open_atlas(store, options);
  for (int i = 0; i < 50; ++i) {
    const auto scan = world.next_scan("car", 1);
    REQUIRE(atlas->commit({&scan, 1}).has_value());
    world.add(scan);
  }
  REQUIRE(atlas->flush().has_value());
  int records = 0;
  REQUIRE(store
              .replay(0,
                      [&](JournalPosition, ByteView) -> Status {
                        ++records;
                        return {};
                      })
              .has_value());
  REQUIRE(records == 50);
  atlas = open_atlas(store, options);
  REQUIRE(world.difference(*atlas) == "");
}

TEST_CASE("any number of scans is one append", "[atlas]") {
  MemoryStore store;
  auto atlas = open_atlas(store);
  int appends = 0;
  store.inject([&](StoreCall call) -> std::optional<StoreFault> {
    appends += call == StoreCall::kAppend ? 1 : 0;
    return std::nullopt;
  });
  std::vector<ShardScan> scans;
  for (std::int64_t seq = 0; seq < 20; ++seq) scans.push_back(small_scan(seq, {key(1), key(9)}));
  const auto changes = test::changes_of(*atlas, scans).value();
  REQUIRE(appends == 1);
  REQUIRE(changes.size() == 40);
  REQUIRE(changes.back().version == 20);
  REQUIRE(test::changes_of(*atlas, scans).value().empty());
  REQUIRE(appends == 1);
  REQUIRE(atlas->stats().scans_applied == 20);
}

TEST_CASE("changes are told tile by tile, each once it is durable and applied", "[atlas]") {
  MemoryStore store;
  auto atlas = open_atlas(store);
  std::vector<ShardScan> scans;
  for (std::int64_t seq = 0; seq < 5; ++seq) scans.push_back(small_scan(seq, {key(1), key(9)}));
  std::vector<std::pair<TileKey, std::uint64_t>> told;
  const auto done = atlas->commit(scans, [&](const TileChange& change) {
    told.emplace_back(change.key, change.version);
    std::size_t records = 0;
    const auto read = store.replay(0, [&](JournalPosition, ByteView) {
      ++records;
      return Status{};
    });
    REQUIRE(read.has_value());
    REQUIRE(records == 5);
    REQUIRE(atlas->stats().deltas_applied == told.size());
  });
  REQUIRE(done.has_value());
  REQUIRE(told.size() == 10);
  for (std::size_t i = 0; i < told.size(); ++i) {
    REQUIRE(told[i].first == told[i / 5 * 5].first);
    REQUIRE(told[i].second == i % 5 + 1);
  }
}

TEST_CASE("a change that was told is not told again when the rest could not be applied",
          "[atlas]") {
  AtlasOptions tight;
  tight.cache_bytes = 1;  // Every tile is read when its turn comes.
  MemoryStore store;
  auto atlas = open_atlas(store, tight);
  const std::vector<TileKey> keys{key(1), key(5), key(9)};
  const auto first = small_scan(0, keys);
  REQUIRE(atlas->commit({&first, 1}).has_value());
  REQUIRE(atlas->flush().has_value());
  const auto scan = small_scan(1, keys);
  std::map<TileKey, int> told;
  const auto tell = [&](const TileChange& change) {
    REQUIRE(change.version == 2);
    ++told[change.key];
  };
  bool broken = false;
  store.inject([&](StoreCall call) -> std::optional<StoreFault> {
    broken = broken || (call == StoreCall::kRead && told.size() == 1);
    if (!broken || call == StoreCall::kAppend) return std::nullopt;
    return StoreFault{ErrorCode::kIo, false};
  });
  REQUIRE_FALSE(atlas->commit({&scan, 1}, tell).has_value());
  REQUIRE(told.size() == 1);
  store.inject({});
  REQUIRE(atlas->commit({&scan, 1}, tell).has_value());
  REQUIRE(told.size() == 3);
  for (const auto& [tile, times] : told) REQUIRE(times == 1);
}

TEST_CASE("a gap is refused, and nothing before it in the commit is applied", "[atlas]") {
  MemoryStore store;
  auto atlas = open_atlas(store);
  const std::vector<ShardScan> scans{small_scan(0, {key(1)}), small_scan(2, {key(1)})};
  const auto refused = atlas->commit(scans);
  REQUIRE(refused.error().code == ErrorCode::kInvalid);
  REQUIRE(refused.error().message.find("scan 2 of source \"car\"") != std::string::npos);
  REQUIRE(atlas->mark("car", 1) == -1);
  REQUIRE(atlas->tile(key(1)).value().tree == nullptr);
}

TEST_CASE("a scan that cannot be is refused whole, in words", "[atlas]") {
  MemoryStore store;
  ModelParameters parameters;
  parameters.shards = 2;
  auto atlas = open_atlas(store, {}, parameters, 1);
  std::uint64_t mine = 0;
  while (shard_of(key(mine), 2) != 1) ++mine;
  std::uint64_t other = 0;
  while (shard_of(key(other), 2) != 0) ++other;
  const auto refused = [&](ShardScan scan, ErrorCode code) {
    REQUIRE(atlas->check_scan(scan).error().code == code);
    REQUIRE(atlas->commit({&scan, 1}).error().code == code);
    REQUIRE(atlas->mark("car", 1) == -1);
  };
  REQUIRE(atlas->check_scan(small_scan(0, {key(mine)})).has_value());
  REQUIRE(atlas->check_scan(small_scan(50, {})).has_value());
  refused(small_scan(0, {key(other)}), ErrorCode::kOutOfRange);
  refused(small_scan(0, {TileKey::from_index({1'000'000, 0, 0}).value()}), ErrorCode::kOutOfRange);
  refused(small_scan(0, {key(mine), key(mine)}), ErrorCode::kCorrupt);
  auto broken = small_scan(0, {key(mine)});
  broken.deltas[0].second.pop_back();
  refused(broken, ErrorCode::kCorrupt);
}

TEST_CASE("a shard keeps its parameters and refuses others, in words", "[atlas]") {
  MemoryStore store;
  REQUIRE_FALSE(Atlas::stored_parameters(store, 0).value().has_value());
  ModelParameters parameters;
  parameters.integration.free_depth = 7;
  const auto owner = open_atlas(store, {}, parameters);
  REQUIRE(Atlas::stored_parameters(store, 0).value() == parameters);
  const auto refused = Atlas::open(store, 0, {}, {});
  REQUIRE(refused.error().code == ErrorCode::kInvalid);
  REQUIRE(refused.error().message.find("free_depth 7, not 4") != std::string::npos);
  const auto scan = small_scan(0, {key(1)});
  REQUIRE(owner->commit({&scan, 1}).has_value());  // The refused one has not taken the shard.
  REQUIRE(Atlas::open(store, 1, parameters, {}).error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("a second owner fences the first", "[atlas]") {
  MemoryStore store;
  const auto first = open_atlas(store);
  const auto second = open_atlas(store);
  const auto scan = small_scan(0, {key(1)});
  REQUIRE(second->commit({&scan, 1}).has_value());
  REQUIRE(first->commit({&scan, 1}).error().code == ErrorCode::kFenced);
  REQUIRE(second->epoch() > first->epoch());
}

TEST_CASE("a journal that skips a version is corrupt, and says where", "[atlas]") {
  MemoryStore store;
  {
    const auto atlas = open_atlas(store);
    const auto scan = small_scan(0, {key(5)});
    REQUIRE(atlas->commit({&scan, 1}).has_value());
    REQUIRE(atlas->flush().has_value());
    const auto next = small_scan(1, {key(5)});
    REQUIRE(atlas->commit({&next, 1}).has_value());
  }
  const auto epoch = store.acquire(0).value();
  const StoredTile older[] = {{key(5), 0, {}}};
  REQUIRE(store.put(0, epoch, older).has_value());
  const auto opened = Atlas::open(store, 0, {}, {});
  REQUIRE(opened.error().code == ErrorCode::kCorrupt);
  REQUIRE(opened.error().message.find("version 2 of tile 0x5") != std::string::npos);
}

TEST_CASE("a version goes on after a tombstone", "[atlas]") {
  MemoryStore store;
  const auto epoch = store.acquire(0).value();
  const StoredTile erased[] = {{key(5), 41, {}}};
  REQUIRE(store.put(0, epoch, erased).has_value());
  const auto atlas = open_atlas(store);
  REQUIRE(atlas->list(key(0), 10).value().empty());
  REQUIRE(atlas->encoded(key(5)).error().code == ErrorCode::kNotFound);
  const auto scan = small_scan(0, {key(5)});
  REQUIRE(test::changes_of(*atlas, {&scan, 1}).value().front().version == 42);
  REQUIRE(atlas->list(key(0), 10).value().front().version == 42);
}

TEST_CASE("a full disk stops new scans, and a freed one lets them on", "[atlas]") {
  AtlasOptions options;
  options.journal_max_bytes = 3000;
  MemoryStore store;
  const auto atlas = open_atlas(store, options);
  store.inject([](StoreCall call) -> std::optional<StoreFault> {
    if (call != StoreCall::kPut) return std::nullopt;  // The journal has room, tiles have none.
    return StoreFault{ErrorCode::kNoSpace, false};
  });
  std::int64_t seq = 0;
  for (;; ++seq) {
    REQUIRE(seq < 200);
    const auto scan = small_scan(seq, {key(1), key(2)});
    const auto done = atlas->commit({&scan, 1});
    if (done) continue;
    REQUIRE(done.error().code == ErrorCode::kNoSpace);
    break;
  }
  REQUIRE(seq > 5);
  REQUIRE(atlas->mark("car", 1) == seq - 1);
  store.inject({});
  const auto scan = small_scan(seq, {key(1), key(2)});
  REQUIRE(test::changes_of(*atlas, {&scan, 1}).value().front().version ==
          static_cast<std::uint64_t>(seq) + 1);
  REQUIRE(atlas->stats().journal_bytes <= options.journal_max_bytes);
}

/// A tile between the clamps, so that one bit a voxel changes it.
TileTree two_hits() {
  TileTree tree;
  for (int i = 0; i < 2; ++i) tree.hit(CellKey{kDepth, 4711}, SensorModel::standard());
  for (int i = 0; i < 3; ++i) tree.hit(CellKey{kDepth, 11}, SensorModel::standard());
  return tree;
}

std::vector<std::uint64_t> rested_codes(Atlas& atlas) {
  std::vector<std::uint64_t> codes;
  for (const auto& info : atlas.rested(100)) codes.push_back(info.key.morton());
  return codes;
}

TEST_CASE("tiles rest once flushed, until they change or are compressed", "[atlas]") {
  AtlasOptions options;
  options.rest_seconds = 0;
  options.rest_bytes = 0;
  MemoryStore store;
  auto atlas = open_atlas(store, options);
  const auto scan = small_scan(0, {key(1), key(2), key(3)});
  REQUIRE(atlas->commit({&scan, 1}).has_value());
  REQUIRE(rested_codes(*atlas).empty());
  REQUIRE(atlas->flush().has_value());
  REQUIRE(rested_codes(*atlas) == std::vector<std::uint64_t>{1, 2, 3});
  const auto next = small_scan(1, {key(2)});
  REQUIRE(atlas->commit({&next, 1}).has_value());
  REQUIRE(rested_codes(*atlas) == std::vector<std::uint64_t>{1, 3});
  const auto tree = *atlas->tile(key(3)).value().tree;
  REQUIRE(atlas->take_encoded({key(3), 1, encode_tile(tree, {TileCodec::kDense})}).value() == 1);
  REQUIRE(rested_codes(*atlas) == std::vector<std::uint64_t>{1});
  REQUIRE(atlas->flush().has_value());
  atlas.reset();

  atlas = open_atlas(store, options);  // What earlier runs left is found again.
  REQUIRE(rested_codes(*atlas) == std::vector<std::uint64_t>{1, 2});
  REQUIRE(codec_of(atlas->encoded(key(3)).value().bytes).value() == TileCodec::kDense);
  AtlasOptions patient;
  patient.rest_seconds = 1000;
  atlas = open_atlas(store, patient);
  const auto third = small_scan(2, {key(7)});
  REQUIRE(atlas->commit({&third, 1}).has_value());
  REQUIRE(atlas->flush().has_value());
  REQUIRE(rested_codes(*atlas).empty());
}

TEST_CASE("a compressor's bytes are refused where they do not decode", "[atlas]") {
  MemoryStore store;
  const auto atlas = open_atlas(store);
  REQUIRE(atlas->take_encoded({key(1), 1, {1, 2, 3}}).error().code == ErrorCode::kCorrupt);
  REQUIRE_FALSE(atlas->take_encoded({key(1), 0, encode_tile({}, {})}).value());
}

TEST_CASE("a tile for which a compressor has no good answer is not handed out again", "[atlas]") {
  AtlasOptions options;
  options.rest_seconds = 0;
  options.rest_bytes = 0;
  MemoryStore store;
  auto atlas = open_atlas(store, options);
  const auto scan = small_scan(0, {key(1), key(2), key(3)});
  REQUIRE(atlas->commit({&scan, 1}).has_value());
  REQUIRE(atlas->flush().has_value());
  REQUIRE_FALSE(atlas->take_encoded({key(1), 1, {}}).has_value());
  const auto other = encode_tile(two_hits(), {TileCodec::kDense});
  REQUIRE_FALSE(atlas->take_encoded({key(2), 1, other}).value());
  REQUIRE(rested_codes(*atlas) == std::vector<std::uint64_t>{3});
  REQUIRE(atlas->stats().resting_tiles == 1);
}

TEST_CASE("a tile too small to gain anything does not rest", "[atlas]") {
  AtlasOptions options;
  options.rest_seconds = 0;
  MemoryStore store;
  auto atlas = open_atlas(store, options);
  const auto scan = small_scan(0, {key(1)});
  REQUIRE(atlas->commit({&scan, 1}).has_value());
  REQUIRE(atlas->flush().has_value());
  options.rest_bytes = atlas->encoded(key(1)).value().bytes.size();
  for (const bool small : {false, true}) {
    options.rest_bytes += small ? 1 : 0;
    atlas = open_atlas(store, options);
    REQUIRE(rested_codes(*atlas).size() == (small ? 0u : 1u));  // Found again.
    MemoryStore fresh;
    atlas = open_atlas(fresh, options);
    REQUIRE(atlas->commit({&scan, 1}).has_value());
    REQUIRE(atlas->flush().has_value());
    REQUIRE(rested_codes(*atlas).size() == (small ? 0u : 1u));  // Just written.
  }
}

/// An atlas that holds two_hits() as tile 1, version 1.
std::unique_ptr<Atlas> atlas_of_two_hits(TileStore& store) {
  auto atlas = open_atlas(store);
  std::vector<ShardScan> scans;
  for (std::int64_t seq = 0; seq < 3; ++seq) {
    TileDelta delta;
    delta.hits.insert(CellKey{kDepth, 11});
    if (seq > 0) delta.hits.insert(CellKey{kDepth, 4711});
    scans.push_back({"car", 1, seq, {{key(1), test::delta_bytes(delta)}}});
  }
  REQUIRE(atlas->commit(scans).has_value());
  REQUIRE(*atlas->tile(key(1)).value().tree == two_hits());
  return atlas;
}

const CodecOptions kOneBit{TileCodec::kLossy, 0, {1, 5}};

TEST_CASE("a lossy tile in which a voxel changed sides is refused", "[atlas]") {
  MemoryStore store;
  const auto atlas = atlas_of_two_hits(store);
  auto other = two_hits();
  other.miss(CellKey{kDepth, 12}, SensorModel::standard());  // It was unknown.
  REQUIRE(atlas->take_encoded({key(1), 3, encode_tile(other, kOneBit)}).error().code ==
          ErrorCode::kCorrupt);
  REQUIRE(*atlas->tile(key(1)).value().tree == two_hits());
  REQUIRE(atlas->tile(key(1)).value().version == 3);
}

TEST_CASE("a lossy put that may have happened is read back", "[atlas]") {
  for (const bool applied : {false, true}) {
    MemoryStore store;
    auto atlas = atlas_of_two_hits(store);
    store.inject([&](StoreCall call) -> std::optional<StoreFault> {
      if (call != StoreCall::kPut) return std::nullopt;
      return StoreFault{ErrorCode::kUnknown, applied};
    });
    const auto bytes = encode_tile(two_hits(), kOneBit);
    REQUIRE_FALSE(atlas->take_encoded({key(1), 3, bytes}).has_value());
    store.inject({});
    auto expected = applied ? decode_tile(bytes).value() : two_hits();
    REQUIRE(*atlas->tile(key(1)).value().tree == expected);
    const auto next = small_scan(3, {key(1)});
    REQUIRE(test::changes_of(*atlas, {&next, 1}).value().front().version == (applied ? 5 : 4));
    expected.hit(CellKey{kDepth, 4711}, SensorModel::standard());
    atlas = open_atlas(store);
    REQUIRE(*atlas->tile(key(1)).value().tree == expected);
  }
}

TEST_CASE("tiles are listed in order, from memory and disk, a page at a time", "[atlas]") {
  MemoryStore store;
  auto atlas = open_atlas(store);
  std::vector<TileKey> keys;
  for (std::uint64_t code = 0; code < 900; code += 3) keys.push_back(key(code));
  const auto stored = small_scan(0, keys);
  REQUIRE(atlas->commit({&stored, 1}).has_value());
  REQUIRE(atlas->flush().has_value());
  std::vector<TileKey> more;
  for (std::uint64_t code = 0; code < 1000; code += 5) more.push_back(key(code));
  const auto dirty = small_scan(1, more);
  REQUIRE(atlas->commit({&dirty, 1}).has_value());
  for (const std::size_t limit : {1, 7, 64, 1000}) {
    std::vector<std::uint64_t> listed;
    for (auto from = key(0);;) {
      const auto page = atlas->list(from, limit).value();
      if (page.empty()) break;
      REQUIRE(page.size() <= limit);
      for (const auto& info : page) {
        const auto code = info.key.morton();
        listed.push_back(code);
        REQUIRE(info.version == (code % 3 == 0 && code < 900) + (code % 5 == 0 ? 1u : 0u));
      }
      from = key(page.back().key.morton() + 1);
    }
    std::vector<std::uint64_t> expected;
    for (std::uint64_t code = 0; code < 1000; ++code) {
      if (code % 5 == 0 || (code % 3 == 0 && code < 900)) expected.push_back(code);
    }
    REQUIRE(listed == expected);
  }
}

}  // namespace
}  // namespace voxatlas
