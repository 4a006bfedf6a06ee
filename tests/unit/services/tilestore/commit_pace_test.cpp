#include "tilestore/commit_pace.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kMost = std::size_t{8} << 20;

/// Commits as large as the pace says, on a machine that applies so many bytes in a millisecond;
/// returns what the last one took, milliseconds.
double commit_on(CommitPace& pace, double bytes_a_ms, int times) {
  double took = 0;
  for (int i = 0; i < times; ++i) {
    took = static_cast<double>(pace.bytes()) / bytes_a_ms;
    pace.applied(pace.bytes(), static_cast<std::int64_t>(took * 1000));
  }
  return took;
}

TEST_CASE("commits take a tenth of a second on any machine, also where it gets slower or faster",
          "[tilestore]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> speed(2'000, 60'000);
  CommitPace pace(kMost);
  for (int change = 0; change < 200; ++change) {
    REQUIRE(commit_on(pace, speed(rng), 30) == Approx(100).epsilon(0.02));
  }
}

TEST_CASE("a machine that is half as fast is seen within a few commits", "[tilestore]") {
  CommitPace pace(kMost);
  REQUIRE(commit_on(pace, 20'000, 30) == Approx(100).epsilon(0.02));
  REQUIRE(commit_on(pace, 10'000, 1) == Approx(200).epsilon(0.02));
  REQUIRE(commit_on(pace, 10'000, 4) < 130);
}

TEST_CASE("a commit keeps within its memory, and never waits for less than there is",
          "[tilestore]") {
  CommitPace fast(kMost), slow(kMost), tiny(1000);
  commit_on(fast, 1e9, 50);
  REQUIRE(fast.bytes() == kMost);
  commit_on(slow, 0.1, 50);
  REQUIRE(slow.bytes() == CommitPace::kFewest);
  REQUIRE(tiny.bytes() == 1000);
  commit_on(tiny, 0.1, 50);
  REQUIRE(tiny.bytes() == 1000);
  CommitPace instant(kMost);  // Empty scans, and a clock that stands still.
  for (int i = 0; i < 1000; ++i) instant.applied(0, 0);
  REQUIRE(instant.bytes() >= CommitPace::kFewest);
  REQUIRE(instant.bytes() <= kMost);
}

}  // namespace
}  // namespace voxatlas
