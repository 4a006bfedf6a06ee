#include "hub/hub_service.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

void word(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

Bytes message(std::uint32_t type, const std::string& channel) {
  Bytes bytes;
  word(bytes, type);
  word(bytes, static_cast<std::uint32_t>(channel.size()));
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  return bytes;
}

Bytes publish(const std::string& channel, std::size_t size, std::uint8_t fill = 7) {
  auto bytes = message(1, channel);
  word(bytes, static_cast<std::uint32_t>(size));
  bytes.insert(bytes.end(), size, fill);
  return bytes;
}

Bytes greeting() {
  Bytes bytes;
  word(bytes, 0x287617fb);
  word(bytes, 0x0100);
  return bytes;
}

/// A client that has greeted and asked for a pattern.
HubService::ClientId join(HubService& hub, const std::string& pattern) {
  const auto id = hub.connect();
  REQUIRE(id.has_value());
  REQUIRE(hub.receive(*id, greeting()).has_value());
  REQUIRE(hub.receive(*id, message(2, pattern)).has_value());
  return *id;
}

/// Everything that waits for a client, taken in pieces of any size, without the hub's greeting.
Bytes taken(HubService& hub, HubService::ClientId id, std::mt19937_64& rng) {
  Bytes all;
  while (hub.has_waiting(id)) {
    Bytes some;
    for (const auto piece : hub.waiting(id, 3)) some.insert(some.end(), piece.begin(), piece.end());
    some.resize(1 + rng() % some.size());
    hub.sent(id, some.size());
    all.insert(all.end(), some.begin(), some.end());
  }
  all.erase(all.begin(), all.begin() + 8);
  return all;
}

TEST_CASE("the hub passes on what is asked for, whatever pieces it comes in", "[hub][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 100; ++run) {
    HubService hub({});
    const auto publisher = join(hub, "NOTHING");
    const auto all = join(hub, ".*");
    const auto some = join(hub, "A");
    Bytes stream, expected;
    for (int i = 0; i < 20; ++i) {
      const bool a = rng() % 2 == 0;
      const auto bytes = publish(a ? "A" : "AB", rng() % 5000, static_cast<std::uint8_t>(rng()));
      stream.insert(stream.end(), bytes.begin(), bytes.end());
      if (a) expected.insert(expected.end(), bytes.begin(), bytes.end());
    }
    for (ByteView rest(stream); !rest.empty();) {
      const auto size = std::min<std::size_t>(rest.size(), 1 + rng() % 4000);
      REQUIRE(hub.receive(publisher, rest.first(size)).has_value());
      rest = rest.subspan(size);
    }
    REQUIRE(taken(hub, all, rng) == stream);
    REQUIRE(taken(hub, some, rng) == expected);
    REQUIRE(taken(hub, publisher, rng).empty());
  }
}

TEST_CASE("the hub's own messages come as any other", "[hub]") {
  auto rng = test::engine();
  HubService hub({});
  const auto client = join(hub, "A");
  const auto expected = publish("A", 10, 7);
  hub.say("A", Bytes(10, 7));
  hub.say("B", Bytes(10, 7));
  REQUIRE(hub.waiting_bytes() >= expected.size());
  REQUIRE(taken(hub, client, rng) == expected);
  REQUIRE(hub.waiting_bytes() == 0);
}

TEST_CASE("a client that asked twice for a pattern goes on until it has taken back both", "[hub]") {
  auto rng = test::engine();
  HubService hub({});
  const auto client = join(hub, "A");
  REQUIRE(hub.receive(client, message(2, "A")).has_value());
  const auto bytes = publish("A", 10);
  REQUIRE(hub.receive(client, bytes).has_value());
  REQUIRE(hub.receive(client, message(3, "A")).has_value());
  REQUIRE(hub.receive(client, bytes).has_value());
  REQUIRE(hub.receive(client, message(3, "A")).has_value());
  REQUIRE(hub.receive(client, bytes).has_value());
  REQUIRE(taken(hub, client, rng).size() == 2 * bytes.size());
}

TEST_CASE("a client that does not read loses messages, and costs no more than its bound", "[hub]") {
  HubConfig config;
  config.max_client_bytes = 100'000;
  HubService hub(config);
  const auto slow = join(hub, ".*");
  const auto publisher = join(hub, "NOTHING");
  for (int i = 0; i < 1000; ++i) REQUIRE(hub.receive(publisher, publish("A", 10'000)).has_value());
  std::size_t waiting = 0;
  for (const auto piece : hub.waiting(slow, 1'000'000)) waiting += piece.size();
  CHECK(waiting <= config.max_client_bytes);
  CHECK(hub.counters().delivered + hub.counters().dropped == 1000);
  CHECK(hub.counters().delivered == 9);
}

TEST_CASE("a client that breaks the protocol is told from the others", "[hub]") {
  HubService hub({});
  const auto good = join(hub, "A");
  const auto refused = [&](const Bytes& bytes, bool greet = true) {
    const auto id = hub.connect();
    if (greet) REQUIRE(hub.receive(*id, greeting()).has_value());
    const auto received = hub.receive(*id, bytes);
    hub.disconnect(*id);
    return !received.has_value();
  };
  CHECK(refused(Bytes(8, 'x'), false));
  CHECK(refused(message(4, "A")));
  CHECK(refused(message(2, "(")));
  CHECK(refused(message(1, std::string(300, 'A'))));
  Bytes endless = message(1, "A");
  word(endless, 0xffffffff);
  CHECK(refused(endless));
  REQUIRE(hub.receive(good, publish("A", 3)).has_value());
  CHECK(hub.waiting(good, 9).size() == 2);
}

TEST_CASE("the hub takes so many clients and subscriptions and no more", "[hub]") {
  HubConfig config;
  config.max_clients = 3;
  config.max_subscriptions = 5;
  HubService hub(config);
  const auto client = join(hub, "A");
  for (int i = 0; i < 4; ++i)
    REQUIRE(hub.receive(client, message(2, fmt::format("B{}", i))).has_value());
  CHECK_FALSE(hub.receive(client, message(2, "C")).has_value());
  REQUIRE(hub.connect().has_value());
  REQUIRE(hub.connect().has_value());
  CHECK_FALSE(hub.connect().has_value());
  hub.disconnect(client);
  CHECK(hub.connect().has_value());
}

TEST_CASE("random bytes from a client do the hub no harm", "[hub]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 2000; ++run) {
    HubService hub({});
    const auto client = join(hub, ".*");
    Bytes bytes(rng() % 200);
    for (auto& byte : bytes) byte = rng() % 2 == 0 ? static_cast<std::uint8_t>(rng() % 4) : 0;
    (void)hub.receive(client, bytes);
  }
}

}  // namespace
}  // namespace voxatlas
