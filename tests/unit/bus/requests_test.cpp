// A store client against a store that loses questions, answers late, twice, in ranges, and changes
// tiles between ranges.
#include "bus/requests.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Answers tile questions from a map, the oracle, as badly as it is told to.
class BadStore {
 public:
  BadStore(Bus& bus, std::mt19937_64& rng) : bus_(bus), ports_(bus), rng_(rng) {
    bus.subscribe<tile_request_t>(kTileRequestChannel,
                                  [this](const tile_request_t& request) { answer(request); });
    bus.subscribe<model_request_t>(kModelRequestChannel, [this](const model_request_t& request) {
      if (request.shard != 0 || ++models_asked < 2) return;
      model_reply_t reply{};
      reply.client = request.client;
      reply.id = request.id;
      reply.mark = 41;
      REQUIRE((*ports_.at(request.reply_port))->publish(kModelReplyChannel, reply).has_value());
    });
  }

  std::map<std::int64_t, std::pair<std::int64_t, Bytes>> tiles;  ///< Version and bytes.
  unsigned lose_one_in = 1'000'000;
  bool change_once = false;
  int models_asked = 0;
  std::set<int> depths;  ///< Those that tiles were asked for at.

 private:
  void answer(const tile_request_t& request) {
    depths.insert(request.depth);
    if (rng_() % lose_one_in == 0) return;
    auto& [version, bytes] = tiles[request.tile];
    tile_reply_t reply{};
    reply.client = request.client;
    reply.id = request.id;
    reply.tile = request.tile;
    reply.version = version;
    reply.total = static_cast<std::int32_t>(bytes.size());
    reply.offset = std::min(request.offset, reply.total);
    reply.size = std::min(59'000, reply.total - reply.offset);
    reply.payload.assign(bytes.begin() + reply.offset, bytes.begin() + reply.offset + reply.size);
    auto* port = *ports_.at(request.reply_port);
    for (auto times = 1 + rng_() % 2; times > 0; --times) {
      REQUIRE(port->publish(kTileReplyChannel, reply).has_value());
    }
    auto stranger = reply;
    ++stranger.client;
    REQUIRE(port->publish(kTileReplyChannel, stranger).has_value());
    if (change_once && request.offset > 0 && changed_.insert(request.tile).second) {
      ++version;
      bytes.assign(bytes.size() / 2 + 1, static_cast<std::uint8_t>(rng_()));
    }
  }

  Bus& bus_;
  ReplyPorts ports_;
  std::mt19937_64& rng_;
  std::set<std::int64_t> changed_;
};

TEST_CASE("tiles are fetched whole, each once, whatever is lost, doubled or changed",
          "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  auto bus = *Bus::create("memq://");
  BadStore store(*bus, rng);
  store.lose_one_in = 20;
  store.change_once = true;
  std::vector<std::pair<std::int32_t, std::int64_t>> wanted;
  for (std::int64_t tile = 0; tile < 60; ++tile) {
    Bytes bytes(tile % 5 == 0 ? 0 : rng() % 200'000);
    for (std::size_t at = 0; at < bytes.size(); at += 101) bytes[at] = static_cast<uint8_t>(rng());
    store.tiles[tile] = {tile % 5 == 0 ? 0 : 1, std::move(bytes)};
    wanted.emplace_back(0, tile);
  }
  StoreClient client(*bus, *bus, Endpoint::for_this_client());
  std::map<std::int64_t, std::pair<std::int64_t, Bytes>> fetched;
  const auto status = client.fetch(wanted, 20'000'000, [&](StoreClient::FetchedTile tile) {
    CHECK(fetched.emplace(tile.tile, std::pair(tile.version, std::move(tile.bytes))).second);
  });
  if (!status) FAIL(status.error().message);
  REQUIRE(fetched.size() == wanted.size());
  REQUIRE(store.depths == std::set{7});
  for (const auto& [tile, is] : fetched) {
    const auto& now = store.tiles[tile];
    // A tile that changed after its last range was asked for may be the one before.
    if (is.first == now.first) REQUIRE(is.second == now.second);
    REQUIRE(now.first - is.first <= 1);
  }
}

TEST_CASE("tiles may be asked for at a depth", "[bus]") {
  auto rng = test::engine();
  auto bus = *Bus::create("memq://");
  BadStore store(*bus, rng);
  store.tiles[5] = {3, Bytes(100'000, std::uint8_t{1})};
  StoreClient client(*bus, *bus, Endpoint::for_this_client());
  int arrived = 0;
  const auto count = [&](const StoreClient::FetchedTile&) { ++arrived; };
  REQUIRE(client.fetch({{0, 5}}, 20'000'000, count, 4).has_value());
  REQUIRE(arrived == 1);
  REQUIRE(store.depths == std::set{4});
}

TEST_CASE("a question is asked again until it is answered", "[bus]") {
  auto rng = test::engine();
  auto bus = *Bus::create("memq://");
  BadStore store(*bus, rng);
  StoreClient client(*bus, *bus, Endpoint::for_this_client());
  const auto reply = client.model(0, "car", 5, 5'000'000);
  REQUIRE(reply.has_value());
  CHECK(reply->mark == 41);
  CHECK(store.models_asked == 2);
}

TEST_CASE("who does not answer is named", "[bus]") {
  auto rng = test::engine();
  auto bus = *Bus::create("memq://");
  BadStore store(*bus, rng);
  store.lose_one_in = 1;
  StoreClient client(*bus, *bus, Endpoint::for_this_client());
  const auto model = client.model(7, "", 0, 30'000);
  REQUIRE_FALSE(model.has_value());
  CHECK(model.error().code == ErrorCode::kUnavailable);
  CHECK(model.error().message.find("tilestore 7") != std::string::npos);
  const auto fetched = client.fetch({{0, 1}, {0, 2}}, 30'000, [](auto) { FAIL(); });
  REQUIRE_FALSE(fetched.has_value());
  CHECK(fetched.error().message.find("2 of 2") != std::string::npos);
}

TEST_CASE("answers go to clients' ports and to no others", "[bus]") {
  auto bus = *Bus::create("memq://");
  ReplyPorts ports(*bus);
  CHECK(*ports.at(0) == bus.get());
  for (std::int32_t port = 400; port < 1000; ++port) REQUIRE(ports.at(port).has_value());
  for (const std::int32_t port : {1, 100, 399, 1000, -1}) {
    REQUIRE(ports.at(port).error().code == ErrorCode::kOutOfRange);
  }
}

TEST_CASE("random ids are neither alike nor negative", "[bus]") {
  std::set<std::int64_t> ids;
  for (int i = 0; i < 10'000; ++i) ids.insert(random_id());
  CHECK(ids.size() == 10'000);
  CHECK(*ids.begin() > 0);
}

}  // namespace
}  // namespace voxatlas
