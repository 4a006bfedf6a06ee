#include "bus/service_loop.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "base/utime.hpp"
#include "bus/channels.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a loop runs handlers, then work, when it is due or woken, until it has finished",
          "[bus]") {
  auto bus = *Bus::create("memq://");
  const int wake = ::eventfd(1, EFD_NONBLOCK);
  int handled = 0, worked = 0;
  bus->subscribe_bytes("A", [&](ByteView) -> Status { return ++handled, Status(); });
  ServiceLoop loop;
  loop.buses = {bus.get(), bus.get()};  // Links share a bus that has no ports.
  loop.wake_fds = {wake};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    if (++worked <= 3) REQUIRE(bus->publish_bytes("A", Bytes(1)).has_value());
    return now + 60'000'000;  // Woken before, by the message or the eventfd.
  };
  loop.finished = [&] { return worked == 6; };
  const auto start = steady_utime();
  REQUIRE(loop.run().has_value());
  CHECK(handled == 3);
  CHECK(steady_utime() - start < 400'000);
  ::close(wake);
}

TEST_CASE("an error of work ends the loop with it", "[bus]") {
  ServiceLoop loop;
  loop.work = [](std::int64_t) -> Result<std::int64_t> {
    return fail(ErrorCode::kNoSpace, "full");
  };
  const auto ended = loop.run();
  REQUIRE_FALSE(ended.has_value());
  CHECK(ended.error().code == ErrorCode::kNoSpace);
}

TEST_CASE("a status goes out when it changes and twice a second, with its counters", "[bus]") {
  auto bus = *Bus::create("memq://");
  std::vector<status_t> seen;
  bus->subscribe<status_t>(kStatusChannel, [&](const status_t& status) { seen.push_back(status); });
  StatusPublisher publisher(*bus, "ingest", 2);
  const auto pump = [&](std::int64_t now) {
    REQUIRE(publisher.pump(now, [] { return StatusCounters{{"scans", 7.0}}; }).has_value());
    REQUIRE(bus->handle_waiting().has_value());
  };
  pump(1'000'000);
  pump(1'400'000);
  CHECK(seen.size() == 1);
  pump(1'500'000);
  CHECK(seen.size() == 2);
  publisher.set_state(true, "ready");
  publisher.set_state(true, "ready");
  pump(1'600'000);
  pump(1'700'000);
  REQUIRE(seen.size() == 3);
  CHECK(seen[0].ready == 0);
  CHECK(seen[2].ready == 1);
  CHECK(seen[2].state == "ready");
  CHECK(seen[2].service == "ingest");
  CHECK(seen[2].index == 2);
  CHECK(seen[2].pid == ::getpid());
  std::vector<std::string> names;
  for (const auto& counter : seen[2].counters) names.push_back(counter.name);
  CHECK(names == std::vector<std::string>{"scans", "kernel_drops", "undecodable"});
  CHECK(seen[2].counters[0].value == 7.0);
  CHECK(publisher.next_pump() == 2'100'000);
  publisher.set_state(false, "full");
  CHECK(publisher.next_pump() == 0);
  CHECK(seen[0].instance == seen[2].instance);
}

TEST_CASE("a signal ends a loop that waits", "[bus]") {
  stop_on_signals();
  int worked = 0;
  ServiceLoop loop;
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    if (++worked == 2) ::raise(SIGTERM);
    return now;
  };
  REQUIRE_FALSE(stop_requested());
  REQUIRE(loop.run().has_value());
  CHECK(stop_requested());
  CHECK(worked == 2);
}

}  // namespace
}  // namespace voxatlas
