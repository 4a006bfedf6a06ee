#include "bus/port_socket.hpp"

#include <lcm/lcm.h>
#include <poll.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>

#include "bus/bus.hpp"
#include "bus/bus_url.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr const char* kPort = "udpm://239.255.76.67:7999?ttl=0";

Bytes datagram_of(const std::string& magic, const std::string& channel, ByteView data) {
  const auto text = magic + "\1\2\3\4" + channel;
  Bytes bytes(text.begin(), text.end());
  bytes.push_back(0);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

/// Oracle: byte by byte, as LCM's own reader goes about it.
std::optional<std::pair<std::string, Bytes>> read_slowly(const Bytes& bytes) {
  std::size_t at = 0;
  for (const char c : std::string("LC02")) {
    if (at == bytes.size() || bytes[at++] != static_cast<std::uint8_t>(c)) return std::nullopt;
  }
  at += 4;
  std::string channel;
  for (; at < bytes.size() && bytes[at] != 0; ++at) channel += static_cast<char>(bytes[at]);
  if (at >= bytes.size() || channel.size() > 63) return std::nullopt;
  return std::pair(channel,
                   Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 1, bytes.end()));
}

TEST_CASE("a short message of LCM's is its channel and its data", "[bus]") {
  const Bytes data{7, 0, 9};
  const auto bytes = datagram_of("LC02", "VOXATLAS_ACK", data);
  const auto message = short_message(bytes);
  REQUIRE(message.has_value());
  CHECK(message->channel == "VOXATLAS_ACK");
  CHECK(Bytes(message->data.begin(), message->data.end()) == data);
  CHECK(message->data.data() == bytes.data() + bytes.size() - data.size());  // Where it was.
  CHECK_FALSE(short_message(datagram_of("LC03", "VOXATLAS_ACK", data)).has_value());
  CHECK(short_message(datagram_of("LC02", std::string(63, 'a'), {})).has_value());
  CHECK_FALSE(short_message(datagram_of("LC02", std::string(64, 'a'), {})).has_value());
}

TEST_CASE("any bytes are read as a short message as LCM reads them", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  int messages = 0;
  for (int i = 0; i < 50'000; ++i) {
    Bytes bytes = datagram_of("LC02", std::string(rng() % 70, 'c'), Bytes(rng() % 4, 1));
    for (auto hits = rng() % 3; hits > 0; --hits) {
      const auto value = rng() % 2 == 0 ? 0 : rng() % 256;
      bytes[rng() % bytes.size()] = static_cast<std::uint8_t>(value);
    }
    if (rng() % 4 == 0) bytes.resize(rng() % (bytes.size() + 1));
    const auto expected = read_slowly(bytes);
    const auto message = short_message(bytes);
    REQUIRE(message.has_value() == expected.has_value());
    if (!message) continue;
    ++messages;
    REQUIRE(message->channel == expected->first);
    REQUIRE(Bytes(message->data.begin(), message->data.end()) == expected->second);
  }
  CHECK(messages > 10'000);
}

/// What LCM itself publishes, from the first byte to the last, and nothing of another group's.
TEST_CASE("a port hears LCM's publishers, of its own group only", "[bus]") {
  if (auto probed = probe_bus(kPort); !probed) {
    std::printf("skipped: %s\n", probed.error().message.c_str());
    return;
  }
  auto port = Bus::create_port(kPort);
  REQUIRE(port.has_value());
  std::vector<Bytes> heard;
  (*port)->subscribe_bytes("A", [&](ByteView bytes) -> Status {
    heard.emplace_back(bytes.begin(), bytes.end());
    return {};
  });
  lcm_t* lcm = lcm_create(kPort);
  lcm_t* others = lcm_create("udpm://239.255.76.68:7999?ttl=0");
  REQUIRE((lcm != nullptr && others != nullptr));
  const Bytes none, small{1, 2, 3}, large(Bus::kMaxPlainBytes, 0x5a);
  const auto publish = [](lcm_t* to, const char* channel, const Bytes& data) {
    REQUIRE(lcm_publish(to, channel, data.data(), static_cast<unsigned>(data.size())) == 0);
  };
  publish(others, "A", Bytes{9});
  publish(lcm, "B", Bytes{8});
  publish(lcm, "A", Bytes(100'000, 7));  // In fragments: none of its pieces is taken for a message.
  const std::vector<Bytes> sent{small, none, large, small};
  for (const auto& bytes : sent) {
    publish(lcm, "A", bytes);
    for (const auto before = heard.size(); heard.size() == before;) {
      pollfd ready{(*port)->fd(), POLLIN, 0};
      REQUIRE(::poll(&ready, 1, 10'000) == 1);
      REQUIRE((*port)->handle_waiting().has_value());
    }
  }
  CHECK(heard == sent);
  CHECK((*port)->counters().received == sent.size());
  lcm_destroy(lcm);
  lcm_destroy(others);
}

TEST_CASE("a port that cannot be joined is refused by name", "[bus]") {
  const auto socket = PortSocket::open("udpm://127.0.0.1:7999?ttl=0");  // No group.
  REQUIRE_FALSE(socket.has_value());
  CHECK(socket.error().message.find("127.0.0.1") != std::string::npos);
}

}  // namespace
}  // namespace voxatlas
