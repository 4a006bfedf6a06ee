#include <catch2/catch.hpp>

#include "../../render/scene.hpp"
#include "base/bytes.hpp"
#include "codec/tile_codec.hpp"
#include "render/request_queue.hpp"
#include "render/store_tiles.hpp"
#include "render/tile_directory.hpp"
#include "render/tree_cache.hpp"

namespace voxatlas {
namespace {

render_request_t request_of(std::int64_t client, std::int64_t id) {
  render_request_t request{};
  request.client = client;
  request.id = id;
  return request;
}

TEST_CASE("the newest request of a client waits in its old place", "[render]") {
  RequestQueue queue;
  REQUIRE(queue.offer(request_of(1, 10)) == RequestQueue::Offer::kWaits);
  REQUIRE(queue.offer(request_of(2, 20)) == RequestQueue::Offer::kWaits);
  REQUIRE(queue.offer(request_of(1, 11)) == RequestQueue::Offer::kReplaced);
  REQUIRE(queue.take()->id == 11);
  REQUIRE(queue.offer(request_of(1, 12)) == RequestQueue::Offer::kWaits);
  REQUIRE(queue.take()->id == 20);
  REQUIRE(queue.take()->id == 12);
  REQUIRE_FALSE(queue.take().has_value());
}

TEST_CASE("more clients than the queue holds are refused", "[render]") {
  RequestQueue queue;
  for (std::int64_t client = 0; client < 1000; ++client) {
    const bool room = client < static_cast<std::int64_t>(RequestQueue::kMaxClients);
    REQUIRE((queue.offer(request_of(client, 0)) == RequestQueue::Offer::kRefused) == !room);
  }
  REQUIRE(queue.size() == RequestQueue::kMaxClients);
}

TileKey key_at(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return TileKey::from_index({x, y, z}).value();
}

TEST_CASE("a directory believes a listing for a second, within its range", "[render]") {
  TileDirectory directory;
  const TileRange range{{10, 10, 10}, {20, 20, 20}};
  REQUIRE_FALSE(directory.knows(range, 5'000'000));
  directory.take(range, {{key_at(12, 12, 12), 3}}, 5'000'000);
  REQUIRE(directory.knows(range, 5'000'001));
  REQUIRE(directory.knows({{11, 12, 13}, {14, 15, 16}}, 5'900'000));
  REQUIRE_FALSE(directory.knows({{9, 12, 13}, {14, 15, 16}}, 5'000'001));
  REQUIRE_FALSE(directory.knows({{11, 12, 13}, {14, 15, 21}}, 5'000'001));
  REQUIRE_FALSE(directory.knows(range, 6'000'000));
  REQUIRE(directory.version(key_at(12, 12, 12)) == 3);
  REQUIRE(directory.version(key_at(13, 12, 12)) == 0);
}

TEST_CASE("a directory keeps the highest version it heard of, in its range only", "[render]") {
  TileDirectory directory;
  const TileRange range{{10, 10, 10}, {20, 20, 20}};
  directory.update(key_at(12, 12, 12), 9);
  REQUIRE(directory.size() == 0);
  directory.take(range, {{key_at(12, 12, 12), 3}}, 1);
  directory.update(key_at(12, 12, 12), 5);
  directory.update(key_at(12, 12, 12), 4);
  directory.update(key_at(15, 15, 15), 1);  // New since the listing.
  directory.update(key_at(25, 15, 15), 1);
  REQUIRE(directory.version(key_at(12, 12, 12)) == 5);
  REQUIRE(directory.size() == 2);
  directory.take(range, {{key_at(12, 12, 12), 4}}, 2);  // Listed before the update.
  REQUIRE(directory.version(key_at(12, 12, 12)) == 5);
  REQUIRE(directory.size() == 2);
  directory.take({{30, 30, 30}, {31, 31, 31}}, {}, 3);
  REQUIRE(directory.size() == 0);
}

Bytes tile_bytes(int cells) {
  TileTree tree;
  for (int i = 0; i < cells; ++i) {
    tree.set({kDepth, static_cast<std::uint32_t>(i * 977 % 2'000'000)}, {3000, {}});
  }
  return encode_tile(tree, {});
}

TEST_CASE("a cache drops what was drawn longest ago, never what is being drawn", "[render]") {
  TreeCache cache(200'000);
  for (std::uint32_t i = 0; i < 10; ++i) {
    cache.begin_picture();
    cache.put(key_at(i, 0, 0), 1, tile_bytes(1000));
    REQUIRE(cache.tree(key_at(i, 0, 0)).value()->cell_count(7) == 1000);
    REQUIRE(cache.tree(key_at(0, 0, 0)).has_value());  // Drawn in every picture.
    cache.trim();
    REQUIRE(cache.bytes() <= 200'000);
  }
  REQUIRE(cache.version(key_at(0, 0, 0)) == 1);
  REQUIRE(cache.version(key_at(1, 0, 0)) == 0);
  REQUIRE(cache.version(key_at(9, 0, 0)) == 1);

  cache.begin_picture();
  for (std::uint32_t i = 20; i < 40; ++i) cache.put(key_at(i, 0, 0), 1, tile_bytes(1000));
  for (std::uint32_t i = 20; i < 40; ++i) REQUIRE(cache.tree(key_at(i, 0, 0)).has_value());
  cache.trim();
  REQUIRE(cache.tiles() == 20);  // All of this picture, above the budget as they are.
  cache.begin_picture();
  cache.trim();
  REQUIRE(cache.bytes() <= 200'000);
}

TEST_CASE("a cache takes newer versions only, and its count of bytes comes back to nothing",
          "[render]") {
  TreeCache cache(0);
  const TileKey key = key_at(1, 2, 3);
  cache.put(key, 2, tile_bytes(10));
  REQUIRE(cache.tree(key).value()->cell_count(7) == 10);
  cache.put(key, 1, tile_bytes(20));
  REQUIRE(cache.tree(key).value()->cell_count(7) == 10);
  cache.put(key, 3, tile_bytes(30));
  REQUIRE(cache.tree(key).value()->cell_count(7) == 30);
  REQUIRE(cache.bytes() > 0);
  cache.begin_picture();
  cache.trim();
  REQUIRE(cache.bytes() == 0);
  REQUIRE(cache.tiles() == 0);
}

TEST_CASE("a tile that is not here, or is none, is an error that names it", "[render]") {
  TreeCache cache(1000);
  const TileKey key = key_at(1, 0, 0);
  REQUIRE(cache.tree(key).error().code == ErrorCode::kNotFound);
  cache.put(key, 1, {9, 9, 9});
  REQUIRE(cache.tree(key).error().code == ErrorCode::kCorrupt);
  REQUIRE_THAT(cache.tree(key).error().message, Catch::Contains("0x1"));
}

TEST_CASE("a page of tiles is read row by row, and a false one refused", "[render]") {
  const Grid grid = Grid::standard();
  tiles_reply_t page{};
  ByteWriter rows(page.rows);
  for (const std::uint64_t key : {5u, 77u}) {
    rows.put<std::uint64_t>(key);
    rows.put<std::uint64_t>(key + 1);
  }
  page.tiles = 2;
  page.size = static_cast<std::int32_t>(page.rows.size());
  const auto listed = listed_tiles(page, grid);
  REQUIRE(listed.has_value());
  REQUIRE(listed->size() == 2);
  REQUIRE((*listed)[1].key.morton() == 77);
  REQUIRE((*listed)[1].version == 78);

  auto wrong = page;
  wrong.tiles = 3;
  REQUIRE(listed_tiles(wrong, grid).error().code == ErrorCode::kCorrupt);
  wrong.tiles = -1;
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
  wrong = page;
  wrong.details = 1;
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
  wrong = page;
  wrong.rows[7] = 0xff;  // A key above 2^63.
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
}

}  // namespace
}  // namespace voxatlas
