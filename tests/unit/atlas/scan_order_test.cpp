#include "atlas/scan_order.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

ShardScan scan(const std::string& source, std::int64_t session, std::int64_t seq) {
  return {source, session, seq, {}};
}

/// Oracle: every number offered so far, in a set; the next one wanted is found by counting up.
struct Seen {
  std::int64_t taken = 0;
  std::set<std::int64_t> offered;

  std::int64_t ready() const {
    std::int64_t next = taken;
    while (offered.count(next) != 0) ++next;
    return next;
  }
};

TEST_CASE("scans leave in order however they arrive", "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 2000; ++run) {
    ScanOrder order;
    std::vector<Seen> seen(3);
    order.start_from({{"a", 1, 9}});  // The second source's session goes on at 10.
    seen[1].taken = 10;
    const std::pair<std::string, std::int64_t> names[] = {{"a", 0}, {"a", 1}, {"b", 0}};
    for (int step = 0; step < 60; ++step) {
      const auto which = rng() % 3;
      auto& oracle = seen[which];
      const auto& [source, session] = names[which];
      const auto seq = oracle.taken - 3 + static_cast<std::int64_t>(rng() % (rng() % 2 ? 8 : 75));
      const auto offer = order.offer(scan(source, session, seq), oracle.taken);
      if (seq < 0 || seq - oracle.taken > ScanOrder::kMaxWaiting) {
        REQUIRE(offer.error().code == ErrorCode::kInvalid);
      } else if (seq < oracle.taken || oracle.offered.count(seq) != 0) {
        REQUIRE(offer.value() == ScanOrder::Offer::kDuplicate);
      } else {
        REQUIRE(offer.value() == ScanOrder::Offer::kTaken);
        oracle.offered.insert(seq);
      }
      if (rng() % 4 != 0) continue;
      std::vector<std::int64_t> next{seen[0].taken, seen[1].taken, seen[2].taken};
      for (const auto& ready : order.take_ready()) {
        const std::size_t i = ready.source == "b" ? 2 : ready.session == 1 ? 1 : 0;
        REQUIRE(ready.seq == next[i]++);
      }
      std::size_t waiting = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        REQUIRE(next[i] == seen[i].ready());
        seen[i].taken = next[i];
        seen[i].offered.erase(seen[i].offered.begin(), seen[i].offered.lower_bound(next[i]));
        waiting += seen[i].offered.size();
        REQUIRE(order.next(names[i].first, names[i].second) == next[i]);
      }
      REQUIRE(order.waiting() == waiting);
    }
  }
}

TEST_CASE("scans that wait are counted in bytes until their turn has come", "[atlas]") {
  ScanOrder order;
  for (const std::int64_t seq : {2, 1}) {
    auto waits = scan("car", 5, seq);
    const auto key = TileKey::from_morton(9).value();
    waits.deltas = {{key, Bytes(static_cast<std::size_t>(100 * seq))}};
    REQUIRE(order.offer(waits, 0).has_value());
  }
  REQUIRE(order.waiting_bytes() == 300);
  REQUIRE(order.offer(scan("car", 5, 0), 0).has_value());
  REQUIRE(order.take_ready().size() == 3);
  REQUIRE(order.waiting_bytes() == 0);
}

TEST_CASE("a shard that lacks acknowledged scans raises the alarm", "[atlas]") {
  ScanOrder order;
  order.start_from({{"car", 5, 41}});
  REQUIRE(order.offer(scan("car", 5, 42), 42).has_value());
  const auto lost = order.offer(scan("car", 5, 43), 43);  // 42 waits, so nobody acknowledged it.
  REQUIRE(lost.error().code == ErrorCode::kInvalid);
  REQUIRE(lost.error().message.find("acknowledged scans are lost") != std::string::npos);
  REQUIRE(order.offer(scan("new", 1, 3), 2).error().code == ErrorCode::kInvalid);
  REQUIRE(order.waiting() == 1);
  REQUIRE(order.take_ready().size() == 1);
  REQUIRE(order.offer(scan("car", 5, 43), 43).has_value());
}

}  // namespace
}  // namespace voxatlas
