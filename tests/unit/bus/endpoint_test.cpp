#include "bus/endpoint.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <set>

#include "bus/bus_url.hpp"

namespace voxatlas {
namespace {

TEST_CASE("every endpoint has a port and a channel of its own", "[bus]") {
  std::set<std::int32_t> ports;
  std::set<std::string> channels;
  std::size_t count = 0;
  for (const auto endpoint_class : {EndpointClass::kIngest, EndpointClass::kStore,
                                    EndpointClass::kCompress, EndpointClass::kClient}) {
    for (std::int32_t index = 0; Endpoint::create(endpoint_class, index); ++index, ++count) {
      const auto endpoint = *Endpoint::create(endpoint_class, index);
      ports.insert(endpoint.port_offset());
      channels.insert(endpoint.chunk_channel());
      const auto client = Endpoint::client_at(endpoint.port_offset());
      REQUIRE(client.has_value() == (endpoint_class == EndpointClass::kClient));
      if (client) REQUIRE(*client == endpoint);
    }
    REQUIRE_FALSE(Endpoint::create(endpoint_class, -1).has_value());
  }
  CHECK(count == 900);
  CHECK(ports.size() == count);
  CHECK(channels.size() == count);
  CHECK(*ports.begin() == 100);
  CHECK(*ports.rbegin() == 999);
  CHECK(channels.contains("VOXATLAS_CHUNK_STORE_0"));
  CHECK(Endpoint::client_at(Endpoint::for_this_client().port_offset()).has_value());
  CHECK(Endpoint::client_at(0).error().code == ErrorCode::kOutOfRange);
  CHECK_FALSE(Endpoint::client_at(INT32_MAX).has_value());
  CHECK_FALSE(Endpoint::client_at(INT32_MIN).has_value());
}

TEST_CASE("a URL comes back as it was, with what it leaves out filled in", "[bus]") {
  const auto full = [](const std::string& url) { return BusUrl::parse(url)->to_string(); };
  CHECK(full("udpm://239.1.2.3:4000?ttl=1&x=y") == "udpm://239.1.2.3:4000?ttl=1&x=y");
  CHECK(full("udpm://") == "udpm://239.255.76.67:7667");
  CHECK(full("udpm://239.1.2.3") == "udpm://239.1.2.3:7667");
  CHECK(full("tcpq://") == "tcpq://127.0.0.1:7700");
  CHECK(full("memq://") == "memq://");
  CHECK_FALSE(BusUrl::parse("udpm://239.1.2.3:4000?ttl=0")->leaves_host());
  CHECK(BusUrl::parse("udpm://239.1.2.3:4000?ttl=1")->leaves_host());
  CHECK_FALSE(BusUrl::parse("tcpq://")->leaves_host());
}

TEST_CASE("what is no bus URL is refused by name", "[bus]") {
  const std::string url = GENERATE(as<std::string>{}, "7667", "://a", "udpm://a:b", "udpm://a:0",
                                   "udpm://a:65536", "udpm://a:-1", "udpm://a:1?ttl");
  const auto parsed = BusUrl::parse(url);
  REQUIRE_FALSE(parsed.has_value());
  CHECK(parsed.error().code == ErrorCode::kInvalid);
  CHECK(parsed.error().message.find(url) != std::string::npos);
}

TEST_CASE("a port of its own moves the port and asks for the largest buffer", "[bus]") {
  const auto moved = BusUrl::parse(*url_at_port("udpm://239.1.2.3:4000?ttl=0", 203));
  CHECK(moved->port == 4203);
  CHECK(moved->option("recv_buf_size") != nullptr);
  CHECK(*url_at_port("udpm://239.1.2.3:4000?recv_buf_size=5000", 1) ==
        "udpm://239.1.2.3:4001?recv_buf_size=5000");
  CHECK(*url_at_port("tcpq://127.0.0.1:7700", 203) == "tcpq://127.0.0.1:7700");
  CHECK(url_at_port("udpm://239.1.2.3:65000", 999).error().code == ErrorCode::kInvalid);
}

TEST_CASE("the receive buffer is what the kernel grants, not what was asked for", "[bus]") {
  const auto given = *receive_buffer_of("udpm://239.1.2.3:4000");
  CHECK(given >= 100'000);
  CHECK(*receive_buffer_of("udpm://239.1.2.3:4000?recv_buf_size=50000") == 100'000);  // It doubles.
  CHECK(*receive_buffer_of("udpm://239.1.2.3:4000?recv_buf_size=2000000000") < 2'000'000'000);
  CHECK(*receive_buffer_of(*url_at_port("udpm://239.1.2.3:4000", 1)) >= given);
  CHECK_FALSE(receive_buffer_of("udpm://239.1.2.3:4000?recv_buf_size=much").has_value());
}

}  // namespace
}  // namespace voxatlas
