#include "atlas/update_tally.hpp"

#include <catch2/catch.hpp>
#include <deque>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kLater = UpdateTally::kQuietUs;

void list(UpdateTally& tally) {
  tally.begin_list();
  tally.end_list(true);
}

TEST_CASE("a shard that is heard of for the first time must be listed", "[atlas]") {
  UpdateTally tally;
  REQUIRE_FALSE(tally.is_complete());
  tally.on_update(1);
  REQUIRE_FALSE(tally.must_list());
  tally.on_status(7, 100, 2);
  REQUIRE(tally.must_list());
  REQUIRE_FALSE(tally.is_complete());
  list(tally);
  REQUIRE(tally.is_complete());
}

TEST_CASE("who hears every update never lists again", "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 100, 0);
  list(tally);
  for (std::uint64_t i = 1; i < 1000; ++i) {
    const auto now = static_cast<std::int64_t>(i) * kLater;
    tally.on_update(now);
    REQUIRE_FALSE(tally.is_complete());  // Until the store has told of it.
    tally.on_status(7, 100 + i, now + kLater);
    REQUIRE(tally.is_complete());
    REQUIRE_FALSE(tally.must_list());
  }
}

TEST_CASE("a loss is listed once it is quiet, not before", "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 0, 0);
  list(tally);
  tally.on_update(1000);
  tally.on_status(7, 2, 1000 + kLater - 1);
  REQUIRE_FALSE(tally.must_list());
  REQUIRE_FALSE(tally.is_complete());
  tally.on_status(7, 2, 1000 + kLater);
  REQUIRE(tally.must_list());
  list(tally);
  REQUIRE(tally.is_complete());
}

TEST_CASE("where everything is lost, every count that changes is listed", "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 0, 0);
  list(tally);
  tally.on_status(7, 5, 10);
  REQUIRE(tally.must_list());
}

TEST_CASE("a store that was started again is listed, whatever it counts", "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 5, 0);
  list(tally);
  tally.on_status(8, 5, 1);
  REQUIRE(tally.must_list());
}

TEST_CASE("updates that come while the shard is listed are counted", "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 5, 0);
  tally.begin_list();
  tally.on_update(1);
  tally.on_update(2);
  tally.on_status(7, 7, 3);
  REQUIRE_FALSE(tally.is_complete());
  tally.end_list(true);
  REQUIRE(tally.is_complete());
}

TEST_CASE("a list that failed, or whose store was started again meanwhile, must be made again",
          "[atlas]") {
  UpdateTally tally;
  tally.on_status(7, 5, 0);
  tally.begin_list();
  tally.end_list(false);
  REQUIRE(tally.must_list());
  tally.begin_list();
  tally.on_status(8, 5, 1);
  tally.end_list(true);
  REQUIRE(tally.must_list());
  list(tally);
  REQUIRE(tally.is_complete());
}

TEST_CASE("whatever is lost, a quiet shard is complete only when nothing is missing",
          "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int run = 0; run < 300; ++run) {
    // The store's updates by number; what the subscriber knows: a set, or everything up to a list.
    UpdateTally tally;
    std::uint64_t published = 0, listed_up_to = 0, heard_since = 0;
    std::int64_t now = 1;
    std::deque<std::uint64_t> on_the_way;
    const auto deliver = [&] {
      if (on_the_way.front() > listed_up_to) ++heard_since;
      on_the_way.pop_front();
      tally.on_update(now);
    };
    const auto tell = [&] {
      while (!on_the_way.empty()) deliver();
      tally.on_status(7, published, now);
      if (tally.must_list()) {
        listed_up_to = published;
        heard_since = 0;
        list(tally);
      }
    };
    tell();
    for (int i = 0; i < 200; ++i) {
      now += 1 + static_cast<std::int64_t>(rng() % 50'000);
      ++published;
      if (rng() % 100 >= 5) on_the_way.push_back(published);
      while (on_the_way.size() > rng() % 3) deliver();
      if (rng() % 10 == 0 && rng() % 100 >= 5) tell();
    }
    // Quiet: the next status makes it good, or the one after a late update.
    for (int statuses = 0; statuses < 2; ++statuses) {
      now += 500'000;
      tell();
    }
    REQUIRE(tally.is_complete());
    REQUIRE(listed_up_to + heard_since == published);
  }
}

}  // namespace
}  // namespace voxatlas
