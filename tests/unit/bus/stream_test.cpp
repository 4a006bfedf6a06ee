// Streams on a simulated wire: whatever it does, each message arrives whole, in order, and once,
// or, after a restart, again only if it was not committed.
#include <array>
#include <catch2/catch.hpp>

#include "bus/ack_ranges.hpp"
#include "bus/checksum.hpp"
#include "bus/requests.hpp"
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

/// Anything a wire, a reader and a buffer may be.
StreamWorld::Setup random_setup(std::mt19937_64& rng) {
  StreamWorld::Setup setup;
  setup.producers = 1 + static_cast<int>(rng() % 4);
  setup.messages = 1 + static_cast<int>(rng() % 12);
  setup.stream.chunk_bytes = 1000 + rng() % 3000;
  setup.stream.send_buffer_bytes = 1 + rng() % 100'000;
  setup.most_bytes = 1 + rng() % 30'000;
  setup.buffer_bytes = std::size_t{1} << (13 + rng() % 6);
  setup.chunks.loss = static_cast<double>(rng() % 30) / 100;
  setup.chunks.duplicate = static_cast<double>(rng() % 20) / 100;
  setup.chunks.delay_us = static_cast<std::int64_t>(1 + rng() % 2000);
  setup.chunks.jitter_us = static_cast<std::int64_t>(rng() % 3000);
  setup.acks = setup.chunks;
  setup.read_every_us = static_cast<std::int64_t>(rng() % 3000);
  setup.commit_after_us = static_cast<std::int64_t>(rng() % 50'000);
  setup.consumer.max_held_bytes = 1 + rng() % 200'000;
  return setup;
}

TEST_CASE("streams survive loss, duplication, reordering and delay", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 1000; ++run) {
    CAPTURE(run);
    StreamWorld world(random_setup(rng), rng);
    REQUIRE(world.run(10 * kMinute));
    require_all(world);
  }
}

TEST_CASE("a wrong bit anywhere in a chunk or an acknowledgement is no worse than its loss",
          "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 1000; ++run) {
    CAPTURE(run);
    auto setup = random_setup(rng);
    setup.damage = static_cast<double>(1 + rng() % 30) / 100;
    StreamWorld world(setup, rng);
    // What a producer forgot by mistake is missed only by a consumer that comes back without it.
    for (auto restarts = rng() % 4; restarts > 0 && !world.done(); --restarts) {
      world.run(static_cast<std::int64_t>(rng() % 200'000));
      world.restart_consumer();
    }
    REQUIRE(world.run(10 * kMinute));
    require_all(world);
  }
}

TEST_CASE("what a consumer has not committed comes again after its restart, the rest does not",
          "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 1000; ++run) {
    CAPTURE(run);
    StreamWorld world(random_setup(rng), rng);
    for (auto restarts = rng() % 4; restarts > 0 && !world.done(); --restarts) {
      world.run(static_cast<std::int64_t>(rng() % 200'000));
      world.restart_consumer();
    }
    REQUIRE(world.run(10 * kMinute));
    require_all(world);
    CHECK(world.again_after_commit == 0);
  }
}

TEST_CASE("a producer that comes back as a new stream goes on with what was not committed",
          "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 1000; ++run) {
    CAPTURE(run);
    StreamWorld world(random_setup(rng), rng);
    for (auto restarts = rng() % 4; restarts > 0 && !world.done(); --restarts) {
      world.run(static_cast<std::int64_t>(rng() % 200'000));
      if (rng() % 2 == 0) world.restart_consumer();
      world.restart_producer(rng() % world.peers.size());
    }
    REQUIRE(world.run(10 * kMinute));
    require_all(world);
  }
}

TEST_CASE("producers on one default buffer share it fairly", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  StreamWorld::Setup setup;
  setup.producers = 8;
  setup.messages = 40;
  setup.least_bytes = setup.most_bytes = 200'000;
  setup.read_every_us = 100;
  StreamWorld world(setup, rng);
  while (world.step()) {
    std::int64_t least = INT64_MAX, most = 0;
    for (const auto& peer : world.peers) {
      least = std::min(least, peer.producer->committed_messages());
      most = std::max(most, peer.producer->committed_messages());
    }
    REQUIRE(most - least <= 3);
  }
  REQUIRE(world.done());
  CHECK(world.overflows == 0);
}

TEST_CASE("a slow consumer slows its producers and holds no more than it may", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  StreamWorld::Setup setup;
  setup.producers = 3;
  setup.messages = 60;
  setup.take_every_us = 5'000;  // One message each.
  setup.consumer.max_held_bytes = 1'000'000;
  setup.stream.send_buffer_bytes = 2'000'000;
  StreamWorld world(setup, rng);
  REQUIRE(world.run(10 * kMinute));
  require_all(world);
  CHECK(world.overflows == 0);
  CHECK(world.most_held <= setup.consumer.max_held_bytes + setup.most_bytes + setup.buffer_bytes);
  for (const auto& peer : world.peers) CHECK(peer.producer->counters().chunks_resent == 0);
}

TEST_CASE("messages in pieces do not block one another where all memory is taken", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  StreamWorld::Setup setup;
  setup.producers = 6;
  setup.messages = 3;
  setup.least_bytes = setup.most_bytes = 900'000;
  setup.consumer.max_held_bytes = 1'000'000;  // Six such messages at once do not fit.
  StreamWorld world(setup, rng);
  REQUIRE(world.run(kMinute));
  require_all(world);
  CHECK(world.most_held <= setup.consumer.max_held_bytes + 900'000 + setup.buffer_bytes);
}

TEST_CASE("a lossy wire still carries most of what it could", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto [loss, least_MBps] =
      GENERATE(table<double, double>({{0.01, 300}, {0.05, 200}, {0.2, 40}}));
  StreamWorld::Setup setup;
  setup.messages = 200;
  setup.least_bytes = setup.most_bytes = 400'000;
  setup.chunks.loss = setup.acks.loss = loss;
  setup.buffer_bytes = 8 << 20;
  StreamWorld world(setup, rng);
  const auto start = world.now;
  REQUIRE(world.run(kMinute));
  require_all(world);
  const double MBps = 200 * 0.4e6 / static_cast<double>(world.now - start);
  CAPTURE(loss, MBps);
  CHECK(MBps > least_MBps);
}

TEST_CASE("a stream that rests says nothing, and begins again without loss", "[bus]") {
  auto rng = test::engine();
  StreamWorld::Setup setup;
  setup.producers = 3;
  setup.messages = 10;
  StreamWorld world(setup, rng);
  REQUIRE(world.run(kMinute));
  for (const auto& peer : world.peers) CHECK(peer.producer->next_poll(world.now) == INT64_MAX);
  world.now += 3'600'000'000;  // An hour: credit lapses, the consumer forgets the streams.
  for (auto& peer : world.peers) {
    for (int i = 0; i < 10; ++i) peer.oracle.offered.emplace_back(200'000, 7);
  }
  REQUIRE(world.run(kMinute));
  require_all(world);
  CHECK(world.overflows == 0);
}

TEST_CASE("a chunk with a wrong byte is refused, and comes again", "[bus]") {
  StreamProducer producer(1, {});
  StreamConsumer consumer(2, {});
  producer.offer(MessageKind::kFrame, Bytes(1000, 5));
  const auto pass = [&](std::int64_t now, bool damage) {
    for (auto chunk : producer.poll(now)) {
      if (damage && chunk.size > 0) chunk.data[500] ^= 1;
      consumer.on_chunk(std::move(chunk), now);
    }
    for (const auto& ack : consumer.poll(now)) producer.on_ack(ack, now);
  };
  pass(1'000'000, true);  // The probe.
  pass(1'000'100, true);  // The chunk.
  CHECK(consumer.take().empty());
  CHECK(consumer.counters().refused == 1);
  for (std::int64_t now = 1'001'000; now < 1'100'000; now += 1000) pass(now, false);
  const auto messages = consumer.take();
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].payload == Bytes(1000, 5));
  CHECK(messages[0].kind == MessageKind::kFrame);
}

TEST_CASE("clients that share a port take their own streams only", "[bus]") {
  ConsumerConfig config;
  config.client = random_id();
  StreamConsumer consumer(1, config);
  StreamProducer own(client_session(config.client), {});
  StreamProducer other(client_session(random_id()), {});
  for (auto* producer : {&own, &other}) {
    producer->offer(MessageKind::kFrame, Bytes(10));
    for (const auto& chunk : producer->poll(1'000'000)) consumer.on_chunk(chunk, 1'000'000);
  }
  const auto acks = consumer.poll(1'000'000);
  REQUIRE(acks.size() == 1);
  CHECK(acks[0].session == own.session());
}

TEST_CASE("hostile chunks and acknowledgements leave a stream working and memory bounded",
          "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  constexpr std::array<std::int64_t, 8> kNumbers{-1, 0, 1, 2, 5, 1 << 20, INT64_MAX, INT64_MIN};
  ConsumerConfig config;
  config.max_held_bytes = 1'000'000;
  config.max_message_bytes = 500'000;
  const auto number = [&] { return kNumbers[rng() % kNumbers.size()]; };
  StreamConsumer consumer(9, config);
  StreamProducer producer(-7, {});
  std::int64_t now = 1'000'000;
  for (int i = 0; i < 60'000; ++i, now += static_cast<std::int64_t>(rng() % 2000)) {
    chunk_t chunk{};
    chunk.session = static_cast<std::int64_t>(rng() % 3000);
    chunk.seq = rng() % 2 == 0 ? number() : static_cast<std::int64_t>(rng() % 3);
    chunk.base = rng() % 2 == 0 ? 0 : number();
    chunk.offered = number();
    chunk.message = rng() % 2 == 0 ? 0 : number();
    chunk.index = static_cast<std::int32_t>(number());
    chunk.count = static_cast<std::int32_t>(number());
    chunk.data.resize(rng() % 3 == 0 ? 0 : rng() % 3000);
    chunk.size = static_cast<std::int32_t>(rng() % 9 == 0 ? number() : chunk.data.size());
    chunk.crc = checksum(chunk);  // A liar, not an accident.
    consumer.on_chunk(chunk, now);
    ack_t ack{};
    ack.session = producer.session();
    ack.incarnation = static_cast<std::int64_t>(rng() % 30);
    ack.received = number();
    ack.committed = number();
    ack.credit = number();
    set_ranges(ack, {{number(), number()}, {number(), number()}});
    ack.crc = checksum(ack);
    producer.on_ack(ack, now);
    (void)producer.poll(now);
    if (i % 16 == 0) {
      (void)consumer.poll(now);
      for (const auto& message : consumer.take()) consumer.commit(message.session, message.number);
    }
    REQUIRE(consumer.held_bytes() <= 2'000'000);
    if (i % 1000 == 0 && producer.has_room()) producer.offer(MessageKind::kScan, Bytes(100'000));
  }
}

}  // namespace
}  // namespace voxatlas
