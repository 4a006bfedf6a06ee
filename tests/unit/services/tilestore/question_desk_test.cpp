#include "tilestore/question_desk.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "store/memory_store.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kTiles = 400;

/// A desk over a model, and one who hears all its answers.
struct Desk {
  Desk() {
    scan_all();
    bus->subscribe<tiles_reply_t>(kTilesReplyChannel,
                                  [this](const tiles_reply_t& reply) { pages.push_back(reply); });
    bus->subscribe<tile_reply_t>(kTileReplyChannel,
                                 [this](const tile_reply_t& reply) { tiles.push_back(reply); });
  }

  TileKey key(std::int64_t x) const {
    return TileKey::from_index({static_cast<std::uint32_t>(500'000 + x), 500'000, 500'000}).value();
  }

  /// One more scan, which gives every tile its next version.
  void scan_all() {
    std::map<std::uint64_t, Bytes> deltas;
    for (std::int64_t x = 0; x < kTiles; ++x) {
      TileDelta delta;
      delta.hits.insert({7, static_cast<std::uint32_t>(x)});
      encode_delta(delta, deltas[key(x).morton()]);
    }
    ShardScan scan{"car", 9, scans++, {}};
    for (auto& [code, bytes] : deltas) {
      scan.deltas.emplace_back(TileKey::from_morton(code).value(), std::move(bytes));
    }
    REQUIRE(atlas->commit({&scan, 1}).has_value());
  }

  template <class Request>
  void ask(const char* channel, Request request, std::int64_t id) {
    request.client = 3;
    request.id = id;
    if (request.deadline == 0) request.deadline = utime_now() + 60'000'000;
    REQUIRE(bus->publish(channel, request).has_value());
    REQUIRE(bus->handle_waiting().has_value());
  }
  void ask_tile(std::int64_t id, std::int64_t x, std::int32_t shard = 0,
                std::int64_t deadline = 0) {
    tile_request_t request{};
    request.tile = static_cast<std::int64_t>(key(x).morton());
    request.shard = shard;
    request.deadline = deadline;
    ask(kTileRequestChannel, request, id);
  }
  void ask_page(std::int64_t id) {
    tiles_request_t request{};
    request.details = 1;
    for (auto& index : request.max_index) index = 999'999;
    ask(kTilesRequestChannel, request, id);
  }

  double counter(const std::string& name) const {
    StatusCounters counters;
    desk.add_to(counters);
    return std::map<std::string, double>(counters.begin(), counters.end()).at(name);
  }

  std::int64_t scans = 0;
  MemoryStore store;
  std::unique_ptr<Atlas> atlas = Atlas::open(store, 0, {}, {}).value();
  TileQueries queries{*atlas, store};
  std::unique_ptr<Bus> bus = Bus::create("memq://").value();
  QuestionDesk desk{*bus, queries, 0};
  std::vector<tiles_reply_t> pages;
  std::vector<tile_reply_t> tiles;
};

TEST_CASE("a question asked again gets the answer made the first time, a new one what is so now",
          "[tilestore]") {
  Desk desk;
  desk.ask_tile(1, 5);
  desk.scan_all();
  desk.ask_tile(1, 5);
  desk.ask_tile(2, 5);
  REQUIRE(desk.tiles.size() == 3);
  CHECK(encode_message(desk.tiles[0]) == encode_message(desk.tiles[1]));
  CHECK(desk.tiles[0].version == 1);
  CHECK(desk.tiles[2].version == 2);
  CHECK(desk.tiles[2].id == 2);
  CHECK(desk.counter("answered_again") == 1);
  // Questions of another type are others, also with the same number.
  desk.ask_page(1);
  CHECK(desk.pages.size() == 1);
}

TEST_CASE("what is for another shard, or too late, is not answered", "[tilestore]") {
  Desk desk;
  desk.ask_tile(1, 5, 1);
  desk.ask_tile(2, 5, 0, utime_now() - 1);
  CHECK(desk.tiles.empty());
  CHECK(desk.counter("bad_requests") == 0);
}

TEST_CASE("what cannot be answered is counted, and the next is answered", "[tilestore][hostile]") {
  Desk desk;
  tile_request_t request{};
  request.tile = INT64_MAX;
  desk.ask(kTileRequestChannel, request, 1);
  request.tile = 0;
  request.reply_port = 77;  // No client's.
  desk.ask(kTileRequestChannel, request, 2);
  CHECK(desk.tiles.empty());
  CHECK(desk.counter("bad_requests") == 2);
  desk.ask_tile(3, 5);
  CHECK(desk.tiles.size() == 1);
}

TEST_CASE("while scans come in some questions are put off, and answered when they rest",
          "[tilestore]") {
  Desk desk;
  std::int64_t id = 0;
  while (desk.counter("questions_put_off") == 0) {
    REQUIRE(++id < 100'000);
    desk.desk.delta_came(steady_utime());
    desk.ask_page(id);
  }
  CHECK(desk.pages.size() == static_cast<std::size_t>(id - 1));
  CHECK(id > 1);
  const auto until = steady_utime() + 60'000'000;
  while (desk.pages.empty() || desk.pages.back().id != id) {
    REQUIRE(steady_utime() < until);
    desk.ask_page(id);
  }
}

}  // namespace
}  // namespace voxatlas
