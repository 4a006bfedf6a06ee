#include "bus/bus.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/random_messages.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

std::unique_ptr<Bus> own_queue() {
  auto bus = Bus::create("memq://");
  REQUIRE(bus.has_value());
  return std::move(*bus);
}

TEST_CASE("a message comes back through a bus as it went", "[bus]") {
  auto rng = test::engine();
  const auto bus = own_queue();
  const auto sent = test::RandomMessages(rng).make<scan_t>();
  int times = 0;
  bus->subscribe<scan_t>(kScanChannel, [&](const scan_t& received) {
    CHECK(encode_message(received) == encode_message(sent));
    ++times;
  });
  REQUIRE(bus->publish(kScanChannel, sent).has_value());
  REQUIRE(bus->publish(kAckChannel, sent).has_value());  // Nobody listens there.
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(times == 1);
  CHECK(bus->counters().received == 1);
  CHECK(bus->counters().published == 2);
}

TEST_CASE("a channel is a name, not a pattern", "[bus]") {
  const auto bus = own_queue();
  int times = 0;
  bus->subscribe_bytes("A.*", [&](ByteView) -> Status { return ++times, Status(); });
  REQUIRE(bus->publish_bytes("ABC", Bytes(1)).has_value());
  REQUIRE(bus->publish_bytes("A.*", Bytes(1)).has_value());
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(times == 1);
}

TEST_CASE("what LCM would lose is refused before it is lost", "[bus]") {
  const auto bus = own_queue();
  CHECK(bus->publish_bytes(kScanChannel, Bytes(Bus::kMaxPlainBytes)).has_value());
  const auto refused = bus->publish_bytes(kScanChannel, Bytes(Bus::kMaxPlainBytes + 1));
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::kOutOfRange);
  CHECK(bus->publish_bytes(kFrameChannel, Bytes(Bus::kMaxFrameBytes)).has_value());
  CHECK_FALSE(bus->publish_bytes(kFrameChannel, Bytes(Bus::kMaxFrameBytes + 1)).has_value());
}

TEST_CASE("a message that does not decode is counted and dropped", "[bus]") {
  const auto bus = own_queue();
  int times = 0;
  bus->subscribe<ack_t>(kAckChannel, [&](const ack_t&) { ++times; });
  REQUIRE(bus->publish_bytes(kAckChannel, Bytes(40, 0xff)).has_value());
  REQUIRE(bus->publish(kAckChannel, ack_t{}).has_value());
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(times == 1);
  CHECK(bus->counters().undecodable == 1);
}

TEST_CASE("an exception from a handler goes round LCM and comes out", "[bus]") {
  const auto bus = own_queue();
  int times = 0;
  bus->subscribe_bytes("A", [&](ByteView) -> Status {
    if (++times == 1) throw std::runtime_error("no memory");
    return {};
  });
  REQUIRE(bus->publish_bytes("A", Bytes(1)).has_value());
  REQUIRE(bus->publish_bytes("A", Bytes(1)).has_value());
  CHECK_THROWS_WITH(bus->handle_waiting(), "no memory");
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(times == 2);
}

TEST_CASE("handlers may come and go inside handlers", "[bus]") {
  const auto bus = own_queue();
  int first = 0, second = 0;
  Bus::Subscription own = 0;
  own = bus->subscribe_bytes("A", [&](ByteView) -> Status {
    ++first;
    bus->unsubscribe(own);
    bus->subscribe_bytes("A", [&](ByteView) -> Status { return ++second, Status(); });
    return {};
  });
  for (int i = 0; i < 3; ++i) REQUIRE(bus->publish_bytes("A", Bytes(1)).has_value());
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(first == 1);
  CHECK(second == 2);
  bus->unsubscribe(own);  // Once more does nothing.
}

TEST_CASE("more messages wait than LCM's own thirty", "[bus]") {
  const auto bus = own_queue();
  int times = 0;
  bus->subscribe_bytes("A", [&](ByteView) -> Status { return ++times, Status(); });
  for (int i = 0; i < 1500; ++i) REQUIRE(bus->publish_bytes("A", Bytes(100)).has_value());
  REQUIRE(bus->handle_waiting().has_value());
  CHECK(times == 1500);
}

TEST_CASE("a bus that cannot be is refused by name", "[bus]") {
  for (const auto* url : {"udpm://127.0.0.1:7667", "nothing://a:1", "udpm"}) {
    const auto bus = Bus::create(url);
    REQUIRE_FALSE(bus.has_value());
    CHECK(bus.error().message.find(url) != std::string::npos);
  }
}

}  // namespace
}  // namespace voxatlas
