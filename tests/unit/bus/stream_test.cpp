// Streams on a simulated wire: whatever it does, each message arrives whole, in order, and once,
// or, after a restart, again only if it was not committed.
#include <catch2/catch.hpp>

#include "bus/stream_world.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using test::StreamWorld;

constexpr std::int64_t kMinute = 60'000'000;

/// Every message came, as often as it may, and as it was offered.
void require_all(const StreamWorld& world) {
  REQUIRE(world.wrong == 0);
  for (const auto& peer : world.peers) {
    const auto count = static_cast<std::int64_t>(peer.oracle.offered.size());
    for (std::int64_t number = 0; number < count; ++number) {
      const auto times = peer.oracle.times.find(number);
      REQUIRE(times != peer.oracle.times.end());
      REQUIRE(times->second <= 1 + world.restarts);
    }
  }
}

TEST_CASE("a stream on a clean wire sends each chunk once and loses none to its buffer", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const int producers = GENERATE(1, 2, 3, 8);
  CAPTURE(producers);
  StreamWorld::Setup setup;
  setup.producers = producers;
  setup.messages = 50;
  setup.read_every_us = 200;
  StreamWorld world(setup, rng);
  REQUIRE(world.run(kMinute));
  require_all(world);
  CHECK(world.overflows == 0);
  for (const auto& peer : world.peers) CHECK(peer.producer->counters().chunks_resent == 0);
}

TEST_CASE("streams survive loss, duplication, reordering and delay", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 300; ++run) {
    StreamWorld::Setup setup;
    setup.producers = 1 + static_cast<int>(rng() % 4);
    setup.messages = 1 + static_cast<int>(rng() % 12);
    setup.stream.chunk_bytes = 1000 + rng() % 3000;
    setup.most_bytes = 1 + rng() % 30'000;
    setup.buffer_bytes = (std::size_t{1} << (13 + rng() % 6));
    setup.chunks = {static_cast<double>(rng() % 30) / 100, static_cast<double>(rng() % 20) / 100,
                    static_cast<std::int64_t>(1 + rng() % 2000),
                    static_cast<std::int64_t>(rng() % 3000)};
    setup.acks = setup.chunks;
    setup.read_every_us = static_cast<std::int64_t>(rng() % 3000);
    setup.commit_after_us = static_cast<std::int64_t>(rng() % 50'000);
    CAPTURE(run);
    StreamWorld world(setup, rng);
    REQUIRE(world.run(10 * kMinute));
    require_all(world);
    for (const auto& peer : world.peers) {
      for (const auto& [number, times] : peer.oracle.times) REQUIRE(times == 1);
    }
  }
}

}  // namespace
}  // namespace voxatlas
