#include "ingest/plain_scans.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <set>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

scan_t whole_scan(const std::string& source, std::int64_t seq, std::size_t points) {
  SensorScan scan;
  for (std::size_t i = 0; i < points; ++i) {
    scan.points_sensor.emplace_back(static_cast<float>(i), static_cast<float>(seq), 1.0f);
    scan.colours.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(seq), 7});
  }
  return to_message(scan, {source, 5, seq}, 0.02, 0);
}

TEST_CASE("parts in any order make the very scan they were cut from", "[ingest]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  PlainScans plain(0, 1, 77);
  for (std::int64_t seq = 0; seq < 20; ++seq) {
    const scan_t sent = whole_scan("car", seq, 1 + rng() % 30'000);
    auto parts = to_parts(sent);
    REQUIRE(parts.has_value());
    std::shuffle(parts->begin(), parts->end(), rng);
    std::optional<scan_t> got;
    for (const auto& part : *parts) {
      REQUIRE(part.getEncodedSize() <= 60'000);
      REQUIRE_FALSE(got.has_value());
      auto offered = plain.offer(part, seq);
      REQUIRE(offered.has_value());
      got = *offered;
    }
    REQUIRE(got.has_value());
    REQUIRE(encode_message(*got) == encode_message(sent));
  }
  REQUIRE(plain.counters().whole == 20);
  REQUIRE(plain.counters().gaps == 0);
}

TEST_CASE("a scan's parts that come twice count once", "[ingest]") {
  PlainScans plain(0, 1, 77);
  const auto parts = *to_parts(whole_scan("car", 0, 10'000));
  int whole = 0;
  for (int round = 0; round < 3; ++round) {
    for (const auto& part : parts) whole += plain.offer(part, round).value().has_value() ? 1 : 0;
  }
  REQUIRE(whole == 1);
  REQUIRE(plain.counters().repeated == 2 * parts.size());
}

TEST_CASE("a scan that is not whole in time is dropped, counted, and shown as a gap", "[ingest]") {
  PlainScans plain(0, 1, 77);
  const auto first = *to_parts(whole_scan("car", 0, 10'000));
  REQUIRE(first.size() > 1);
  REQUIRE_FALSE(plain.offer(first[0], 0).value().has_value());
  plain.expire(PlainScans::kPatience + 1);
  REQUIRE(plain.counters().incomplete == 1);
  REQUIRE(plain.offer(whole_scan("car", 1, 5), PlainScans::kPatience + 2).value().has_value());
  REQUIRE(plain.counters().gaps == 1);
}

TEST_CASE("scans that are adopted have no gaps, whatever was lost before", "[ingest]") {
  PlainScans plain(0, 1, 77);
  std::int64_t expected = 0;
  for (const std::int64_t seq : {0, 3, 4, 9}) {
    auto whole = plain.offer(whole_scan("car", seq, 5), 0).value();
    REQUIRE(whole.has_value());
    plain.adopt(*whole);
    REQUIRE(whole->source == "car~plain");
    REQUIRE(whole->session == 77);
    REQUIRE(whole->seq == expected++);
  }
  REQUIRE(plain.counters().gaps == 6);
}

TEST_CASE("a scan that comes late fills its gap", "[ingest]") {
  PlainScans plain(0, 1, 77);
  for (const std::int64_t seq : {0, 2, 1}) {
    REQUIRE(plain.offer(whole_scan("car", seq, 5), 0).value().has_value());
  }
  REQUIRE(plain.counters().gaps == 0);
}

TEST_CASE("of several ingests exactly one takes a source", "[ingest]") {
  std::set<std::int32_t> used;
  for (int source = 0; source < 100; ++source) {
    int takers = 0;
    for (std::int32_t i = 0; i < 4; ++i) {
      if (!PlainScans(i, 4, 1).is_ours(fmt::format("car{}", source))) continue;
      ++takers;
      used.insert(i);
    }
    REQUIRE(takers == 1);
  }
  REQUIRE(used.size() == 4);
}

TEST_CASE("parts that contradict are refused, with their values", "[ingest]") {
  PlainScans plain(0, 1, 77);
  auto parts = *to_parts(whole_scan("car", 0, 10'000));
  REQUIRE(plain.offer(parts[0], 0).has_value());
  scan_t other = parts[1];
  other.sigma = 0.5;
  REQUIRE(plain.offer(other, 0).error().code == ErrorCode::kCorrupt);
  scan_t beyond = parts[1];
  beyond.part = beyond.parts;
  REQUIRE(plain.offer(beyond, 0).error().code == ErrorCode::kOutOfRange);
  scan_t many = parts[1];
  many.parts = 65;
  REQUIRE(plain.offer(many, 0).error().code == ErrorCode::kOutOfRange);
  scan_t nameless = parts[1];
  nameless.source.clear();
  REQUIRE(plain.offer(nameless, 0).error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("a thousand sources that never finish cost bounded memory", "[ingest]") {
  PlainScans plain(0, 1, 77);
  for (int i = 0; i < 5'000; ++i) {
    auto part = (*to_parts(whole_scan(fmt::format("s{}", i), 0, 10'000)))[0];
    REQUIRE(plain.offer(part, 0).has_value());
  }
  REQUIRE(plain.counters().incomplete == 5'000 - PlainScans::kMaxOpen);
  std::uint64_t refused = 0;
  for (int i = 0; i < 2'000; ++i) {
    refused += plain.offer(whole_scan(fmt::format("w{}", i), 0, 1), 0).has_value() ? 0 : 1;
  }
  REQUIRE(refused == 2'000 - PlainScans::kMaxSources);
}

}  // namespace
}  // namespace voxatlas
