// Links on a real bus: in the process's own queue (memq) everywhere, and on multicast where the
// machine has it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/stream_link.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr const char* kMulticast = "udpm://239.255.76.67:7667?ttl=0";

bool has(const std::string& url) {
  const auto probed = probe_bus(url);
  if (!probed) std::printf("skipped: %s\n", probed.error().message.c_str());
  return probed.has_value();
}

std::vector<Bytes> random_messages(std::mt19937_64& rng, int count, std::size_t most) {
  std::vector<Bytes> messages;
  for (int i = 0; i < count; ++i) {
    Bytes bytes(rng() % most);
    for (std::size_t at = 0; at < bytes.size(); at += 97) bytes[at] = static_cast<uint8_t>(rng());
    messages.push_back(std::move(bytes));
  }
  return messages;
}

/// Sends the messages from `out` to `in`, everything on this thread, and returns what arrived.
std::vector<Bytes> carry(Bus& bus, OutLink& out, InLink& in, const std::vector<Bytes>& messages) {
  std::vector<Bytes> arrived;
  std::size_t offered = 0;
  const auto end = steady_utime() + 30'000'000;
  while (out.producer().committed_messages() < static_cast<std::int64_t>(messages.size()) &&
         steady_utime() < end) {
    while (offered < messages.size() && out.producer().has_room()) {
      out.producer().offer(MessageKind::kTileRaw, messages[offered++]);
    }
    REQUIRE(out.pump(steady_utime()).has_value());
    REQUIRE(in.port().handle_waiting().has_value());
    for (auto& message : in.consumer().take()) {
      in.consumer().commit(message.session, message.number);
      arrived.push_back(std::move(message.payload));
    }
    REQUIRE(in.pump(steady_utime()).has_value());
    REQUIRE(bus.handle_waiting().has_value());
  }
  return arrived;
}

TEST_CASE("a link carries messages of any size, in order, on any bus", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const std::string url = GENERATE(as<std::string>{}, "memq://", kMulticast,
                                   "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=106496");
  if (url != "memq://" && !has(url)) return;
  auto bus = Bus::create(url);
  REQUIRE(bus.has_value());
  const auto endpoint = Endpoint::create(EndpointClass::kStore, 3);
  auto in = InLink::create(**bus, *endpoint, {});
  REQUIRE(in.has_value());
  auto out = OutLink::create(**bus, *endpoint, {});
  REQUIRE(out.has_value());
  const auto messages = random_messages(rng, 60, 700'000);
  REQUIRE(carry(**bus, **out, **in, messages) == messages);
}

TEST_CASE("where the bus leaves the machine, each chunk fits an Ethernet packet", "[bus]") {
  // In a network namespace of its own only: nothing may truly leave the machine.
  const char* in_namespace = std::getenv("VOX_NAMESPACE");
  const std::string url = "udpm://239.255.76.67:7667?ttl=1";
  if (in_namespace == nullptr || std::string(in_namespace) != "1" || !has(url)) return;
  auto rng = test::engine();
  auto bus = Bus::create(url);
  REQUIRE(bus.has_value());
  const auto endpoint = Endpoint::create(EndpointClass::kStore, 4);
  auto in = InLink::create(**bus, *endpoint, {});
  REQUIRE(in.has_value());
  auto out = OutLink::create(**bus, *endpoint, {});
  REQUIRE(out.has_value());
  std::size_t largest = 0;
  (*in)->port().subscribe_bytes(endpoint->chunk_channel(), [&](ByteView chunk) -> Status {
    largest = std::max(largest, chunk.size());
    return {};
  });
  const auto messages = random_messages(rng, 20, 100'000);
  REQUIRE(carry(**bus, **out, **in, messages) == messages);
  CHECK(largest > 1'300);
  CHECK(largest <= 1'400);
}

}  // namespace
}  // namespace voxatlas
