#include "bus/status_counters.hpp"

#include <catch2/catch.hpp>
#include <map>

namespace voxatlas {
namespace {

std::map<std::string, double> by_name(const StatusCounters& counters) {
  return {counters.begin(), counters.end()};
}

TEST_CASE("both ends of a stream state their queues, credit and what was sent again", "[bus]") {
  StreamProducer producer(5, StreamConfig{});
  StreamConsumer consumer(9, ConsumerConfig{});
  for (int i = 0; i < 3; ++i) producer.offer(MessageKind::kScan, Bytes(50'000));
  std::int64_t now = 1;
  int lost = 0;
  const auto exchange = [&] {
    for (const auto& chunk : producer.poll(now)) {
      if (chunk.count > 0 && lost++ == 0) continue;  // The first of all.
      consumer.on_chunk(chunk, now);
    }
    for (const auto& ack : consumer.poll(now)) producer.on_ack(ack, now);
    now += 1000;
  };
  exchange();  // The probe: there is credit now.
  StatusCounters out, in;
  add_outgoing(std::vector{&producer}, out);
  add_incoming(consumer, in);
  CHECK(by_name(out)["out_held_bytes"] == 150'000);
  CHECK(by_name(out)["out_credit"] == static_cast<double>(producer.credit()));
  CHECK(producer.credit() > 0);
  CHECK(by_name(in)["in_credit"] == static_cast<double>(producer.credit()));
  CHECK(by_name(in)["in_producers"] == 1);
  for (int i = 0; i < 20; ++i) exchange();
  out.clear();
  in.clear();
  add_outgoing(std::vector{&producer}, out);
  add_incoming(consumer, in);
  CHECK(by_name(out)["out_resent"] == 1);
  CHECK(by_name(out)["out_chunks"] == 4);
  CHECK(by_name(in)["in_chunks"] == 3);
  CHECK(by_name(in)["in_gaps"] >= 1);
  CHECK(by_name(in)["in_held_bytes"] == 150'000);
}

TEST_CASE("the newest scan of each source is stated, the last heard of first", "[bus]") {
  SourceMarks marks;
  marks.note("car", 7, 3);
  marks.note("van", 8, 40);
  marks.note("car", 7, 4);
  marks.note("car", 7, 2);  // Of another ingest, late.
  StatusCounters counters;
  marks.add_to(counters);
  CHECK(counters == StatusCounters{{"seq car/7", 4}, {"seq van/8", 40}});
}

TEST_CASE("of very many sources those heard of last are stated", "[bus]") {
  SourceMarks marks;
  for (std::int64_t i = 0; i < 1000; ++i) marks.note("car", i, 5);
  StatusCounters counters;
  marks.add_to(counters);
  REQUIRE(counters.size() == SourceMarks::kMost);
  CHECK(counters.front().first == "seq car/999");
}

}  // namespace
}  // namespace voxatlas
