// voxatlas-hub: a bus over TCP where multicast does not work.
//
//   every channel, from every client to every client that asked for it (LCM's tcpq protocol)
//   out  VOXATLAS_STATUS
//
// A last resort: correct, not fast. Clients use the URL tcpq://127.0.0.1:PORT.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "bus/service_main.hpp"
#include "hub/hub_server.hpp"

namespace voxatlas {

struct Options {
  std::string address = "127.0.0.1";
  std::int32_t port = 7700;
  std::string probe;
};

static void declare(CLI::App& app, Options& options);
static Status serve(const Options& options);
static StatusPublisher hub_status(HubService& hub);
static StatusCounters counters_of(const HubService& hub);
static int probe(const std::string& url);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Options options;
  CLI::App app{"voxatlas hub: carries the bus over TCP where there is no multicast"};
  voxatlas::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  if (!options.probe.empty()) return voxatlas::probe(options.probe);
  return voxatlas::run_service("hub", voxatlas::Precedence::kFirst,
                               [&] { return voxatlas::serve(options); });
}

namespace voxatlas {

static void declare(CLI::App& app, Options& options) {
  app.add_option("--port", options.port, "TCP port; 0 takes a free one and says which")
      ->check(CLI::Range(0, 65'535))
      ->capture_default_str();
  app.add_option("--address", options.address,
                 "address to listen on; anything but 127.0.0.1 lets others write to the model")
      ->capture_default_str();
  app.add_option("--probe", options.probe,
                 "do not serve: try this bus URL with a 60 kB message to itself; exit code 0 if it "
                 "comes back, else 1 and the reason");
  app.add_flag_callback("--log-json", log_as_json, "log each event as one JSON object");
}

static Status serve(const Options& options) {
  auto server = HubServer::listen(options.address, options.port, HubConfig{});
  if (!server) return pass_on(server);
  fmt::print("ready {}\n", (*server)->port());
  std::fflush(stdout);
  auto status = hub_status((*server)->service());
  while (!stop_requested()) {
    const auto now = steady_utime();
    auto served = status.pump(now, [&] { return counters_of((*server)->service()); });
    const auto wait_us = std::clamp<std::int64_t>(status.next_pump() - now, 0, 500'000);
    if (served) served = (*server)->serve(static_cast<int>(wait_us / 1000) + 1);
    if (!served) return served;
  }
  return {};
}

/// The hub is no client of its own: it puts its status among the messages it carries.
static StatusPublisher hub_status(HubService& hub) {
  StatusPublisher status(
      [&hub](const status_t& message) -> Status {
        hub.say(kStatusChannel, encode_message(message));
        return {};
      },
      "hub", 0);
  status.set_state(true, "ready");
  return status;
}

static StatusCounters counters_of(const HubService& hub) {
  const auto number = [](auto value) { return static_cast<double>(value); };
  const auto& counted = hub.counters();
  return {{"clients", number(counted.clients)},
          {"messages", number(counted.messages)},
          {"delivered", number(counted.delivered)},
          {"dropped", number(counted.dropped)},
          {"out_held_bytes", number(hub.waiting_bytes())}};
}

static int probe(const std::string& url) {
  const auto probed = probe_bus(url);
  if (!probed) fmt::print(stderr, "voxatlas-hub: {}\n", probed.error().message);
  return probed ? 0 : 1;
}

}  // namespace voxatlas
