#include "tilestore/tile_queries.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "base/utime.hpp"
#include "codec/tile_codec.hpp"
#include "octree/tile_hash.hpp"
#include "store/memory_store.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kCorner = 500'000;

/// A model of `tiles` tiles in a row along x, the first ones with many mixed bricks.
std::unique_ptr<Atlas> model(MemoryStore& store, std::uint32_t tiles, int cells) {
  auto rng = test::engine();
  auto atlas = Atlas::open(store, 0, {}, {}).value();
  ShardScan scan{"car", 9, 0, {}};
  std::map<std::uint64_t, Bytes> deltas;
  for (std::uint32_t x = 0; x < tiles; ++x) {
    TileDelta delta;
    for (int i = 0; i < cells; ++i) {
      delta.hits.insert({7, static_cast<std::uint32_t>(rng() % (1u << 21))});
    }
    encode_delta(delta, deltas[TileKey::from_index({kCorner + x, kCorner, kCorner})->morton()]);
  }
  for (auto& [key, bytes] : deltas) {
    scan.deltas.emplace_back(TileKey::from_morton(key).value(), std::move(bytes));
  }
  REQUIRE(atlas->commit({&scan, 1}).has_value());
  return atlas;
}

tiles_request_t everything() {
  tiles_request_t request{};
  request.client = 3;
  for (auto& index : request.max_index) index = 999'999;
  return request;
}

TEST_CASE("pages together name every tile once, in key order", "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1'500, 1);
  TileQueries queries(*atlas, store);
  auto request = everything();
  request.details = GENERATE(std::int8_t{0}, std::int8_t{1});
  const std::size_t row_bytes = request.details == 1 ? 80 : 16;
  std::vector<std::uint64_t> keys;
  while (request.from >= 0) {
    const auto reply = queries.answer(request);
    REQUIRE(reply.has_value());
    REQUIRE(reply->getEncodedSize() <= 60'000);
    REQUIRE(reply->rows.size() == static_cast<std::size_t>(reply->tiles) * row_bytes);
    for (std::size_t at = 0; at < reply->rows.size(); at += row_bytes) {
      ByteReader reader(ByteView(reply->rows).subspan(at, row_bytes));
      keys.push_back(reader.get<std::uint64_t>());
      REQUIRE(reader.get<std::uint64_t>() == 1);  // Version.
      if (request.details == 0) continue;
      const auto key = TileKey::from_morton(keys.back()).value();
      const auto hash = tile_hash(key, *atlas->tile(key)->tree);
      const ByteView got = reader.get_bytes(hash.size());
      REQUIRE(std::equal(got.begin(), got.end(), hash.begin()));
    }
    request.from = reply->next;
  }
  REQUIRE(keys.size() == 1'500);
  REQUIRE(std::is_sorted(keys.begin(), keys.end()));
  REQUIRE(std::set(keys.begin(), keys.end()).size() == keys.size());
}

TEST_CASE("a box gives the tiles in it and no others", "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 100, 1);
  TileQueries queries(*atlas, store);
  auto request = everything();
  request.min_index[0] = kCorner + 10;
  request.max_index[0] = kCorner + 19;
  const auto reply = queries.answer(request);
  REQUIRE(reply->tiles == 10);
  request.min_index[0] = kCorner + 20;
  REQUIRE(queries.answer(request).error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("a large tile comes whole in ranges", "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 200'000);
  TileQueries queries(*atlas, store);
  const auto key = TileKey::from_index({kCorner, kCorner, kCorner}).value();
  tile_request_t request{};
  request.tile = static_cast<std::int64_t>(key.morton());
  request.depth = kDepth;
  Bytes bytes;
  int ranges = 0;
  do {
    request.offset = static_cast<std::int32_t>(bytes.size());
    const auto reply = queries.answer(request);
    REQUIRE(reply.has_value());
    REQUIRE(reply->getEncodedSize() <= 60'000);
    REQUIRE(reply->version == 1);
    bytes.insert(bytes.end(), reply->payload.begin(), reply->payload.end());
    ++ranges;
    if (bytes.size() == static_cast<std::size_t>(reply->total)) break;
  } while (ranges < 1'000);
  REQUIRE(ranges > 1);
  REQUIRE(decode_tile(bytes).value() == *atlas->tile(key)->tree);
}

/// One hit more in the tile at the corner.
void change(Atlas& atlas) {
  TileDelta delta;
  delta.hits.insert({7, 1'234'567});
  ShardScan scan{"car", 9, atlas.mark("car", 9) + 1, {}};
  scan.deltas.emplace_back(TileKey::from_index({kCorner, kCorner, kCorner}).value(), Bytes{});
  encode_delta(delta, scan.deltas[0].second);
  REQUIRE(atlas.commit({&scan, 1}).has_value());
}

TEST_CASE("ranges that were begun are of one version, whatever is written between them",
          "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 200'000);
  TileQueries queries(*atlas, store);
  const auto key = TileKey::from_index({kCorner, kCorner, kCorner}).value();
  const TileTree before = *atlas->tile(key)->tree;
  tile_request_t request{};
  request.tile = static_cast<std::int64_t>(key.morton());
  request.depth = kDepth;
  Bytes bytes;
  for (int ranges = 0; ranges < 1'000; ++ranges) {
    request.offset = static_cast<std::int32_t>(bytes.size());
    const auto reply = queries.answer(request);
    REQUIRE(reply->version == 1);
    bytes.insert(bytes.end(), reply->payload.begin(), reply->payload.end());
    if (bytes.size() == static_cast<std::size_t>(reply->total)) break;
    change(*atlas);
  }
  REQUIRE(decode_tile(bytes).value() == before);
  request.offset = 0;
  const auto version = queries.answer(request)->version;
  REQUIRE(version > 1);
  REQUIRE(version == static_cast<std::int64_t>(atlas->tile(key)->version));
}

TEST_CASE("the figures of a tile are those of its version", "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 2, 10);
  TileQueries queries(*atlas, store);
  auto request = everything();
  request.details = 1;
  const auto before = queries.answer(request)->rows;
  REQUIRE(queries.answer(request)->rows == before);
  change(*atlas);
  const auto after = queries.answer(request)->rows;
  const auto key = TileKey::from_index({kCorner, kCorner, kCorner}).value();
  const auto hash = tile_hash(key, *atlas->tile(key)->tree);
  REQUIRE(std::equal(hash.begin(), hash.end(), after.begin() + 16));
  REQUIRE_FALSE(std::equal(hash.begin(), hash.end(), before.begin() + 16));
  REQUIRE(std::equal(before.begin() + 80, before.end(), after.begin() + 80));
}

TEST_CASE("a tile can be asked for at any depth, in ever fewer bytes, written or not",
          "[tilestore][oracle]") {
  MemoryStore store;
  auto atlas = model(store, 1, 20'000);
  TileQueries queries(*atlas, store);
  const auto key = TileKey::from_index({kCorner, kCorner, kCorner}).value();
  if (GENERATE(false, true)) REQUIRE(atlas->flush().has_value());
  const TileTree tree = *atlas->tile(key)->tree;
  tile_request_t request{};
  request.tile = static_cast<std::int64_t>(key.morton());
  std::size_t deeper = SIZE_MAX;
  for (int depth = kDepth - 1; depth >= 0; --depth) {
    request.depth = static_cast<std::int8_t>(depth);
    const auto reply = queries.answer(request);
    REQUIRE(reply.has_value());
    REQUIRE(reply->version == 1);
    REQUIRE(reply->total == reply->size);
    REQUIRE(decode_tile(reply->payload).value() == cut_tile(tree, depth));
    REQUIRE(reply->payload.size() <= deeper);
    if (depth > 2) REQUIRE(reply->payload.size() < deeper);
    deeper = reply->payload.size();
  }
  REQUIRE(deeper < 40);
}

TEST_CASE("questions that cannot be are refused, and a tile never written has version 0",
          "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 1);
  TileQueries queries(*atlas, store);
  tile_request_t request{};
  request.tile = -1;
  REQUIRE_FALSE(queries.answer(request).has_value());
  request.tile = 12;
  REQUIRE(queries.answer(request)->version == 0);
  request.tile =
      static_cast<std::int64_t>(TileKey::from_index({kCorner, kCorner, kCorner})->morton());
  request.offset = -5;
  REQUIRE_FALSE(queries.answer(request).has_value());
  request.offset = 0;
  request.depth = 8;
  REQUIRE_FALSE(queries.answer(request).has_value());
}

TEST_CASE("a range beyond a tile's end, which shrank since the range before, has a sound answer",
          "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 1);
  TileQueries queries(*atlas, store);
  tile_request_t request{};
  request.tile = GENERATE(as<std::int64_t>{}, 12,  // Never written.
                          TileKey::from_index({kCorner, kCorner, kCorner})->morton());
  const auto whole = queries.answer(request);
  request.offset = 1 << 20;
  const auto beyond = queries.answer(request);
  REQUIRE(beyond.has_value());
  REQUIRE(check_fields(*beyond).has_value());
  REQUIRE(beyond->size == 0);
  REQUIRE(beyond->offset == whole->total);  // Not what was asked for: the asker begins again.
  REQUIRE(beyond->version == whole->version);
}

TEST_CASE("a shard says who it is and where a source stands", "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 1);
  TileQueries queries(*atlas, store);
  model_request_t request{};
  request.source = "car";
  request.session = 9;
  const auto reply = queries.answer(request);
  REQUIRE(reply->mark == 0);
  REQUIRE(decode_parameters(reply->parameters).value() == ModelParameters{});
  request.session = 10;
  REQUIRE(queries.answer(request)->mark == -1);
}

TEST_CASE(
    "a shard says whose a source is, and raises an alarm where his acknowledged scans are lost",
    "[tilestore]") {
  MemoryStore store;
  auto atlas = model(store, 1, 1);
  TileQueries queries(*atlas, store);
  model_request_t request{};
  request.source = "car";
  request.session = 9;  // Of which scan 0 is there.
  REQUIRE(queries.answer(request)->holder == 0);
  request.client = 5;
  request.claim = 1;
  request.acked_below = 1;
  REQUIRE(queries.answer(request)->holder == 5);
  REQUIRE(queries.marks_regressed() == 0);
  request.acked_below = 2;
  REQUIRE(queries.answer(request)->mark == 0);
  REQUIRE(queries.marks_regressed() == 1);
  request.client = 6;  // Not the publisher: what it says is not believed.
  REQUIRE(queries.answer(request)->holder == 5);
  REQUIRE(queries.marks_regressed() == 1);
  request.client = 5;
  request.claim = 2;
  REQUIRE(queries.answer(request)->holder == 0);
}

}  // namespace
}  // namespace voxatlas
