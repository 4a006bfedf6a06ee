#include "tilestore/tilestore_service.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "base/utime.hpp"
#include "codec/tile_codec.hpp"
#include "octree/tile_hash.hpp"
#include "store/memory_store.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileKey tile(std::uint32_t x) {
  return TileKey::from_index({500'000 + x, 500'000, 500'000}).value();
}

/// A scan that changes a few of eight tiles.
scan_delta_t random_delta(std::mt19937_64& rng, std::int64_t seq) {
  scan_delta_t message{};
  message.source = "car";
  message.session = 9;
  message.seq = seq;
  message.parameters = parameters_id(ModelParameters{});
  message.shards = 1;
  ByteWriter writer(message.data);
  for (std::uint32_t x = 0; x < 8; ++x) {
    if (rng() % 2 == 0) continue;
    TileDelta delta;
    delta.misses.depth = 4;
    for (int i = 0; i < 5; ++i) {
      delta.misses.insert({4, static_cast<std::uint32_t>(rng() % 2'048)});
      delta.hits.insert({7, static_cast<std::uint32_t>((2'048u << 9) + rng() % 100'000)});
    }
    Bytes bytes;
    encode_delta(delta, bytes);
    writer.put(tile(x).morton());
    writer.put(static_cast<std::uint32_t>(bytes.size()));
    writer.put_bytes(bytes);
    ++message.tiles;
  }
  message.size = static_cast<std::int32_t>(message.data.size());
  return message;
}

std::vector<std::pair<TileKey, ByteView>> deltas_of(const scan_delta_t& message) {
  std::vector<std::pair<TileKey, ByteView>> deltas;
  ByteReader reader(message.data);
  for (std::int32_t i = 0; i < message.tiles; ++i) {
    const auto key = TileKey::from_morton(reader.get<std::uint64_t>()).value();
    deltas.emplace_back(key, reader.get_bytes(reader.get<std::uint32_t>()));
  }
  return deltas;
}

/// Oracle: every delta applied in seq order to plain trees.
std::map<std::uint64_t, TileTree> applied_in_order(const std::vector<scan_delta_t>& messages) {
  std::map<std::uint64_t, TileTree> trees;
  for (const auto& message : messages) {
    for (const auto& [key, bytes] : deltas_of(message)) {
      trees[key.morton()].apply(*decode_delta(bytes), SensorModel::standard());
    }
  }
  return trees;
}

struct Outcome {
  std::vector<TilestoreService::Acknowledgement> acknowledged;
  std::vector<tile_update_t> updates;
};

Outcome commit(TilestoreService& service) {
  Outcome outcome;
  auto done =
      service.commit([&](const tile_update_t& update) { outcome.updates.push_back(update); });
  outcome.acknowledged = done.value();
  return outcome;
}

struct Fixture {
  MemoryStore store;
  std::unique_ptr<Atlas> atlas = Atlas::open(store, 0, {}, {}).value();
  TilestoreService service{*atlas};

  Outcome commit() { return voxatlas::commit(service); }
};

TEST_CASE("deltas in any order, doubled, by several streams, make the model of their order",
          "[tilestore]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::vector<scan_delta_t> scans;
  for (std::int64_t seq = 0; seq < 60; ++seq) scans.push_back(random_delta(rng, seq));
  auto arrivals = scans;
  arrivals.insert(arrivals.end(), scans.begin(), scans.end());
  std::shuffle(arrivals.begin(), arrivals.end(), rng);

  Fixture set;
  std::map<std::int64_t, std::int64_t> sent, acknowledged;  // By stream.
  for (const auto& message : arrivals) {
    const std::int64_t stream = 1 + static_cast<std::int64_t>(rng() % 3);
    set.service.take(message, stream, sent[stream]++);
    for (const auto& done : set.commit().acknowledged) {
      REQUIRE(done.number >= acknowledged[done.session]);
      acknowledged[done.session] = done.number + 1;
    }
  }
  REQUIRE(acknowledged == sent);
  REQUIRE(set.atlas->mark("car", 9) == 59);
  REQUIRE(set.service.counters().duplicates == 60);
  for (const auto& [key, tree] : applied_in_order(scans)) {
    const auto tile_key = TileKey::from_morton(key).value();
    const auto kept = set.atlas->tile(tile_key);
    REQUIRE(kept.has_value());
    REQUIRE(tile_hash(tile_key, *kept->tree) == tile_hash(tile_key, tree));
  }
}

TEST_CASE("a delta is acknowledged only when every scan before it is applied", "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  set.service.take(random_delta(rng, 1), 5, 0);
  REQUIRE(set.commit().acknowledged.empty());
  REQUIRE(set.atlas->mark("car", 9) == -1);
  set.service.take(random_delta(rng, 0), 6, 0);
  const auto outcome = set.commit();
  REQUIRE(outcome.acknowledged.size() == 2);
  REQUIRE(set.atlas->mark("car", 9) == 1);
}

TEST_CASE("updates tell each tile's new version, one more each time", "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  std::map<std::int64_t, std::int64_t> versions;
  for (std::int64_t seq = 0; seq < 20; ++seq) {
    set.service.take(random_delta(rng, seq), 5, seq);
    const auto outcome = set.commit();
    for (const auto& update : outcome.updates) {
      REQUIRE(update.version == ++versions[update.tile]);
      REQUIRE(update.content == 1);
      REQUIRE(decode_delta(update.payload).has_value());
    }
  }
}

TEST_CASE("all updates of a commit say when it became durable, not when they were sent",
          "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  for (std::int64_t seq = 0; seq < 8; ++seq) set.service.take(random_delta(rng, seq), 5, seq);
  std::int64_t first = 0, count = 0;
  const auto done = set.service.commit([&](const tile_update_t& update) {
    if (first == 0) first = update.utime;
    REQUIRE(update.utime == first);
    ++count;
    while (utime_now() == first) {  // Until the clock shows another time than the first's.
    }
  });
  REQUIRE(done.has_value());
  REQUIRE(count > 1);
}

TEST_CASE("no more is taken than a commit can apply in its time, and after it there is room again",
          "[tilestore]") {
  auto rng = test::engine();
  MemoryStore store;
  auto atlas = Atlas::open(store, 0, {}, {}).value();
  TilestoreService service(*atlas, 3'000);
  std::size_t taken = 0;
  std::int64_t seq = 0;
  for (; service.has_room(); ++seq) {
    const scan_delta_t delta = random_delta(rng, seq);
    for (const auto& [key, bytes] : deltas_of(delta)) taken += bytes.size();
    service.take(delta, 5, seq);
    REQUIRE(seq < 1'000);
  }
  REQUIRE(taken >= 3'000);
  REQUIRE(taken < 6'000);
  commit(service);
  REQUIRE(service.has_room());
}

TEST_CASE("a slow applying leaves less for the next commit", "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  const auto room = [&](std::int64_t& seq) {
    std::int64_t scans = 0;
    for (; set.service.has_room(); ++seq, ++scans) {
      set.service.take(random_delta(rng, seq), 5, seq);
      REQUIRE(scans < 100'000);
    }
    return scans;
  };
  std::int64_t seq = 0;
  const std::int64_t before = room(seq);
  // The last update keeps the commit until it has taken three times as long as it should.
  std::int64_t began = 0;
  const auto done = set.service.commit([&](const tile_update_t&) {
    if (began == 0) began = steady_utime();
    while (steady_utime() - began < 3 * CommitPace::kLongest) {
    }
  });
  REQUIRE(done.has_value());
  REQUIRE(room(seq) < before * 3 / 4);
}

tile_encoded_t encoded_of(Atlas& atlas, TileKey key, const CodecOptions& how) {
  const auto now = atlas.tile(key).value();
  tile_encoded_t message{};
  message.tile = static_cast<std::int64_t>(key.morton());
  message.version = static_cast<std::int64_t>(now.version);
  message.payload = encode_tile(*now.tree, how);
  message.size = static_cast<std::int32_t>(message.payload.size());
  return message;
}

TEST_CASE("a lossy result is a version of its own, told as a whole tile, and lives on",
          "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  for (std::int64_t seq = 0; seq < 12; ++seq) {
    std::mt19937_64 again(
        static_cast<std::uint64_t>(seq % 5));  // Voxels seen twice, others thrice.
    set.service.take(random_delta(again, seq), 5, seq);
  }
  set.commit();
  const CodecOptions one_bit{TileCodec::kLossy, 0, {1, 5}};
  std::uint32_t x = 0;  // The first tile that one bit changes.
  while (quantize(*set.atlas->tile(tile(x)).value().tree, one_bit.lossy) ==
         *set.atlas->tile(tile(x)).value().tree) {
    ++x;
  }
  const TileKey key_of_it = tile(x);
  const auto before = set.atlas->tile(key_of_it).value();
  const std::uint64_t version = before.version;
  REQUIRE(version > 1);
  const auto late = encoded_of(*set.atlas, key_of_it, {TileCodec::kDense});
  const auto lossy = encoded_of(*set.atlas, key_of_it, one_bit);
  TileTree expected = quantize(*before.tree, one_bit.lossy);

  const auto update = set.service.take(lossy);
  REQUIRE(update.has_value());
  REQUIRE(update->version == static_cast<std::int64_t>(version) + 1);
  REQUIRE(update->content == 2);
  REQUIRE(decode_tile(update->payload).value() == expected);
  REQUIRE_FALSE(set.service.take(lossy).has_value());  // Once only.
  REQUIRE_FALSE(set.service.take(late).has_value());
  REQUIRE(set.service.counters().encoded_lossy == 1);
  REQUIRE(set.service.counters().encoded_stale == 2);

  const auto next = random_delta(rng, 12);
  set.service.take(next, 5, 12);
  set.commit();
  for (const auto& [key, bytes] : deltas_of(next)) {
    if (key == key_of_it) expected.apply(*decode_delta(bytes), SensorModel::standard());
  }
  REQUIRE(*set.atlas->tile(key_of_it).value().tree == expected);
  set.atlas.reset();
  set.atlas = Atlas::open(set.store, 0, {}, {}).value();  // Without a flush: from the journal.
  REQUIRE(*set.atlas->tile(key_of_it).value().tree == expected);
}

TEST_CASE("an exact result keeps the version, and nobody is told", "[tilestore]") {
  auto rng = test::engine();
  Fixture set;
  for (std::int64_t seq = 0; seq < 12; ++seq) set.service.take(random_delta(rng, seq), 5, seq);
  set.commit();
  const auto exact = encoded_of(*set.atlas, tile(3), {TileCodec::kDense});
  REQUIRE_FALSE(set.service.take(exact).has_value());
  REQUIRE(set.service.counters().encoded_taken == 1);
  REQUIRE(set.atlas->encoded(tile(3)).value().bytes == exact.payload);
  REQUIRE(static_cast<std::int64_t>(set.atlas->tile(tile(3)).value().version) == exact.version);
}

TEST_CASE("deltas of another model or shard, or that do not decode, are never acknowledged",
          "[tilestore]") {
  auto rng = test::engine();
  scan_delta_t message = random_delta(rng, 0);
  SECTION("parameters") { ++message.parameters; }
  SECTION("shard") { message.shard = 1; }
  SECTION("shards") { message.shards = 2; }
  SECTION("data cut") { message.data.resize(message.data.size() - 1); }
  SECTION("delta broken") {
    std::fill(message.data.begin() + 12, message.data.end(), std::uint8_t{0xff});
  }
  SECTION("tiles") { ++message.tiles; }
  Fixture set;
  set.service.take(message, 5, 0);
  REQUIRE(set.commit().acknowledged.empty());
  REQUIRE(set.service.counters().refused == 1);
  REQUIRE(set.atlas->mark("car", 9) == -1);
  // The right one, by another stream, still finds its place.
  set.service.take(random_delta(rng, 0), 6, 0);
  REQUIRE(set.commit().acknowledged.size() == 1);
}

TEST_CASE("a restarted store goes on from its marks", "[tilestore]") {
  auto rng = test::engine();
  MemoryStore store;
  const auto first = random_delta(rng, 0);
  {
    auto atlas = Atlas::open(store, 0, {}, {}).value();
    TilestoreService service(*atlas);
    service.take(first, 5, 0);
    REQUIRE(commit(service).acknowledged.size() == 1);
  }  // No flush: as a kill would leave it.
  auto atlas = Atlas::open(store, 0, {}, {}).value();
  TilestoreService service(*atlas);
  service.take(first, 7, 0);
  REQUIRE(service.counters().duplicates == 1);
  REQUIRE(commit(service).acknowledged.size() == 1);
  service.take(random_delta(rng, 1), 7, 1);
  REQUIRE(commit(service).acknowledged.at(0).number == 1);
}

}  // namespace
}  // namespace voxatlas
