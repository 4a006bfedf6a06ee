#include "tilestore/handout.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileKey tile(std::uint64_t code) { return TileKey::from_morton(code).value(); }

constexpr std::int64_t kSecond = 1'000'000;

TEST_CASE("tiles go to who has least, each compressor a few", "[tilestore]") {
  Handout handout(3);
  std::vector<Handout::Seen> seen(3, {true, true, 5 * kSecond});
  seen[1].has_room = false;
  std::map<std::size_t, std::size_t> given;
  for (std::uint64_t code = 0; auto to = handout.whom(seen, 5 * kSecond); ++code) {
    handout.given(tile(code), *to, 5 * kSecond);
    ++given[*to];
  }
  REQUIRE(given == std::map<std::size_t, std::size_t>{{0, 16}, {2, 16}});
  handout.answered(tile(0));
  REQUIRE(handout.whom(seen, 5 * kSecond) == std::size_t{0});
  handout.answered(tile(0));  // Twice is once.
  REQUIRE(handout.out() == 31);
}

TEST_CASE("no more tiles are out than memory is meant for", "[tilestore]") {
  Handout handout(10);
  const std::vector<Handout::Seen> seen(10, {true, true, kSecond});
  std::uint64_t code = 0;
  while (auto to = handout.whom(seen, kSecond)) handout.given(tile(code++), *to, kSecond);
  REQUIRE(code == Handout::kMaxOut);
}

TEST_CASE("a compressor never heard of is tried with one tile, which another gets in time",
          "[tilestore]") {
  Handout handout(2);
  std::vector<Handout::Seen> seen{{true, true, 20 * kSecond}, {true, false, 0}};
  std::int64_t now = 20 * kSecond;
  handout.given(tile(1), 0, now);
  REQUIRE(handout.whom(seen, now) == std::size_t{1});
  handout.given(tile(2), 1, now);
  seen[1].holds = true;
  REQUIRE(handout.whom(seen, now) == std::size_t{0});
  for (; now < 30 * kSecond; now += kSecond) {
    seen[0].last_heard = now;
    REQUIRE(handout.take_back(seen, now) == 0);
    REQUIRE(handout.whom(seen, now) == std::size_t{0});
  }
  now = seen[0].last_heard = 31 * kSecond;
  REQUIRE(handout.take_back(seen, now) == 1);
  REQUIRE_FALSE(handout.has(tile(2)));
  REQUIRE(handout.has(tile(1)));
}

TEST_CASE("a compressor that starves but is heard of keeps its tiles for an hour", "[tilestore]") {
  Handout handout(2);
  std::vector<Handout::Seen> seen(2, {true, true, kSecond});
  handout.given(tile(7), 0, kSecond);
  for (std::int64_t now = kSecond; now < 3600 * kSecond; now += kSecond) {
    if (now % (8 * kSecond) == 0) seen[0].last_heard = now;
    seen[1].last_heard = now;
    REQUIRE(handout.take_back(seen, now) == 0);
    const bool quiet = now - seen[0].last_heard > Handout::kQuiet && now > 3 * kSecond;
    if (quiet) REQUIRE(handout.whom(seen, now) == std::size_t{1});
  }
}

TEST_CASE("whatever happens each tile is with one compressor, and with none that is full",
          "[tilestore][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  Handout handout(4);
  std::vector<Handout::Seen> seen(4);
  std::map<std::uint64_t, std::size_t> out;  // The oracle.
  for (std::int64_t now = kSecond; now < 2000 * kSecond; now += 100'000) {
    for (auto& one : seen) {
      one = {rng() % 8 != 0, rng() % 2 == 0, rng() % 30 == 0 ? now : one.last_heard};
    }
    const std::size_t before = out.size();
    const std::size_t back = handout.take_back(seen, now);
    std::erase_if(out, [&](const auto& entry) { return !handout.has(tile(entry.first)); });
    REQUIRE(before - out.size() == back);
    const std::uint64_t code = rng() % 200;
    if (rng() % 3 == 0) {
      handout.answered(tile(code));
      out.erase(code);
    } else if (!out.contains(code)) {
      if (const auto to = handout.whom(seen, now)) {
        handout.given(tile(code), *to, now);
        out.emplace(code, *to);
        REQUIRE(seen[*to].has_room);
      }
    }
    REQUIRE(handout.out() == out.size());
    for (std::size_t i = 0; i < 4; ++i) {
      const auto has = std::count_if(out.begin(), out.end(),
                                     [&](const auto& entry) { return entry.second == i; });
      REQUIRE(static_cast<std::size_t>(has) <= Handout::kMaxOutEach);
    }
  }
}

}  // namespace
}  // namespace voxatlas
