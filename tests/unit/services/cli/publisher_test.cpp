#include "cli/publisher.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "base/utime.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kPatienceUs = 60'000'000;

/// An ingest that makes one scan durable each `every` rounds, the oldest first.
class Ingest {
 public:
  Ingest(Bus& bus, std::int32_t index, int every)
      : in_(InLink::create(bus, Endpoint::create(EndpointClass::kIngest, index).value(), {})
                .value()),
        every_(every) {}

  void turn(int round) {
    for (auto& message : in_->consumer().take()) {
      seqs.push_back(decode_message<scan_t>(message.payload).value().seq);
      waiting_.push_back(std::move(message));
    }
    if (round % every_ == 0 && !waiting_.empty()) {
      in_->consumer().commit(waiting_.front().session, waiting_.front().number);
      waiting_.pop_front();
    }
    REQUIRE(in_->pump(steady_utime()).has_value());
  }

  std::vector<std::int64_t> seqs;  ///< Of the scans that came.

 private:
  std::unique_ptr<InLink> in_;
  int every_;
  std::deque<StreamMessage> waiting_;
};

scan_t numbered(std::int64_t seq) {
  scan_t scan{};
  scan.source = "car";
  scan.seq = seq;
  scan.parts = 1;
  return scan;
}

TEST_CASE("scans go to whichever ingest keeps up, and each to one", "[cli]") {
  constexpr std::int64_t kScans = 600;
  auto bus = Bus::create("memq://").value();
  Ingest fast(*bus, 0, 1), slow(*bus, 1, 10);
  auto publisher = Publisher::create(*bus, 2, steady_utime()).value();
  const auto end = steady_utime() + kPatienceUs;
  std::int64_t next = 0;
  std::size_t most_in_flight = 0;
  for (int round = 0; publisher->durable() < kScans && steady_utime() < end; ++round) {
    while (next < kScans && publisher->has_room(steady_utime())) {
      publisher->publish(numbered(next++), steady_utime());
    }
    most_in_flight = std::max(most_in_flight, publisher->in_flight());
    REQUIRE(publisher->pump(steady_utime()).has_value());
    REQUIRE(bus->handle_waiting().has_value());
    fast.turn(round);
    slow.turn(round);
    REQUIRE(bus->handle_waiting().has_value());
  }
  REQUIRE(publisher->durable() == kScans);
  REQUIRE(publisher->durable_below() == kScans);
  REQUIRE(most_in_flight == Publisher::kMaxInFlight);
  REQUIRE(slow.seqs.size() >= Publisher::kMaxInFlight / 2);
  REQUIRE(fast.seqs.size() > 4 * slow.seqs.size());
  std::set<std::int64_t> all(fast.seqs.begin(), fast.seqs.end());
  all.insert(slow.seqs.begin(), slow.seqs.end());
  REQUIRE(all.size() == kScans);
  REQUIRE(fast.seqs.size() + slow.seqs.size() == kScans);
  REQUIRE(*all.rbegin() == kScans - 1);
}

TEST_CASE("a publisher knows how long its scans took to be durable", "[cli]") {
  auto bus = Bus::create("memq://").value();
  Ingest ingest(*bus, 0, 1);
  std::int64_t now = steady_utime();
  auto publisher = Publisher::create(*bus, 1, now).value();
  const auto end = steady_utime() + kPatienceUs;
  std::uint64_t scans = 0;
  for (const std::int64_t took : {20'000, 5'000}) {
    publisher->publish(numbered(took), now);
    REQUIRE(publisher->pump(now).has_value());
    now += took;
    for (++scans; publisher->durable() < scans && steady_utime() < end;) {
      REQUIRE(bus->handle_waiting().has_value());
      ingest.turn(0);
      REQUIRE(bus->handle_waiting().has_value());
      REQUIRE(publisher->pump(now).has_value());
    }
  }
  REQUIRE(publisher->durable() == 2);
  REQUIRE(publisher->delay().sum == 25'000);
  REQUIRE(publisher->delay().most == 20'000);
}

TEST_CASE("ingests that are equally idle take turns", "[cli]") {
  constexpr std::int64_t kScans = 20;
  auto bus = Bus::create("memq://").value();
  Ingest one(*bus, 0, 1), other(*bus, 1, 1);
  auto publisher = Publisher::create(*bus, 2, steady_utime()).value();
  const auto end = steady_utime() + kPatienceUs;
  for (std::int64_t seq = 0; seq < kScans; ++seq) {
    publisher->publish(numbered(seq), steady_utime());
    while (publisher->in_flight() > 0 && steady_utime() < end) {
      REQUIRE(publisher->pump(steady_utime()).has_value());
      REQUIRE(bus->handle_waiting().has_value());
      one.turn(0);
      other.turn(0);
    }
  }
  REQUIRE(publisher->durable() == kScans);
  REQUIRE(one.seqs.size() == kScans / 2);
  REQUIRE(other.seqs.size() == kScans / 2);
}

}  // namespace
}  // namespace voxatlas
