// The hub as LCM's own clients meet it, on 127.0.0.1.
#include "hub/hub_server.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/stream_link.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// A hub that serves on a thread of its own until it goes.
class RunningHub {
 public:
  explicit RunningHub(std::int32_t port = 0) {
    auto server = HubServer::listen("127.0.0.1", port, {});
    REQUIRE(server.has_value());
    server_ = std::move(*server);
    url_ = fmt::format("tcpq://127.0.0.1:{}", server_->port());
    thread_ = std::thread([this] {
      while (!stop_) (void)server_->serve(5);
    });
  }
  ~RunningHub() {
    stop_ = true;
    thread_.join();
  }

  const std::string& url() const { return url_; }
  std::int32_t port() const { return server_->port(); }

 private:
  std::unique_ptr<HubServer> server_;
  std::string url_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

void wait_for(Bus& bus, std::int64_t us) {
  pollfd ready{bus.fd(), POLLIN, 0};
  ::poll(&ready, 1, static_cast<int>(us / 1000));
}

/// Sends `count` random messages over a stream through the hub; true if all came, as they went.
bool carries(Bus& sending, Bus& receiving, int count) {
  auto rng = test::engine();
  const auto endpoint = Endpoint::create(EndpointClass::kIngest, 0);
  auto in = InLink::create(receiving, *endpoint, {});
  auto out = OutLink::create(sending, *endpoint, {});
  std::vector<Bytes> messages, arrived;
  for (int i = 0; i < count; ++i) {
    messages.emplace_back(rng() % 400'000, static_cast<std::uint8_t>(rng()));
    (*out)->producer().offer(MessageKind::kScan, messages.back());
  }
  const auto end = steady_utime() + 20'000'000;
  while ((*out)->producer().committed_messages() < count && steady_utime() < end) {
    REQUIRE((*out)->pump(steady_utime()).has_value());
    wait_for(receiving, 1000);
    REQUIRE(receiving.handle_waiting().has_value());
    for (auto& message : (*in)->consumer().take()) {
      (*in)->consumer().commit(message.session, message.number);
      arrived.push_back(std::move(message.payload));
    }
    REQUIRE((*in)->pump(steady_utime()).has_value());
    REQUIRE(sending.handle_waiting().has_value());
  }
  return arrived == messages;
}

TEST_CASE("the bus works through the hub: the probe's echo and a stream", "[hub]") {
  RunningHub hub;
  const auto probed = probe_bus(hub.url());
  if (!probed) FAIL(probed.error().message);
  auto one = Bus::create(hub.url());
  auto other = Bus::create(hub.url());
  REQUIRE((one && other));
  REQUIRE(carries(**one, **other, 20));
}

TEST_CASE("clients find a hub again that was away, and a stream goes on", "[hub]") {
  auto hub = std::make_unique<RunningHub>();
  const auto port = hub->port();
  auto one = Bus::create(hub->url());
  auto other = Bus::create(hub->url());
  REQUIRE((one && other));
  REQUIRE(carries(**one, **other, 3));
  hub.reset();
  REQUIRE((*one)->handle_waiting().has_value());
  REQUIRE((*other)->handle_waiting().has_value());
  const auto refused = (*one)->publish_bytes("A", Bytes(10));
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::kUnavailable);
  hub = std::make_unique<RunningHub>(port);
  REQUIRE(carries(**one, **other, 3));
}

TEST_CASE("without a hub, a bus says so", "[hub]") {
  std::string url;
  {
    RunningHub hub;
    url = hub.url();
  }
  const auto bus = Bus::create(url);
  REQUIRE_FALSE(bus.has_value());
  CHECK(bus.error().code == ErrorCode::kUnavailable);
  CHECK(bus.error().message.find(url) != std::string::npos);
  CHECK_FALSE(HubServer::listen("127.0.0.1", 70'000, {}).has_value());
  CHECK_FALSE(HubServer::listen("localhost", 0, {}).has_value());
}

}  // namespace
}  // namespace voxatlas
