#include "render/coverage.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "render/workers.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("coverage agrees with a picture of booleans", "[coverage][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  Coverage coverage;
  for (int round = 0; round < 20; ++round) {
    const int width = std::uniform_int_distribution<int>(1, Coverage::kWidth)(rng);
    const int height = std::uniform_int_distribution<int>(1, 150)(rng);
    coverage.reset(width, height);
    std::vector<char> drawn(static_cast<std::size_t>(width * height));
    const auto at = [&](int x, int y) -> char& {
      return drawn[static_cast<std::size_t>(y * width + x)];
    };
    const auto random_rect = [&](int largest) {
      PixelRect rect;
      rect.xa = std::uniform_int_distribution<int>(0, width - 1)(rng);
      rect.ya = std::uniform_int_distribution<int>(0, height - 1)(rng);
      rect.xb = std::min(width - 1, rect.xa + std::uniform_int_distribution<int>(0, largest)(rng));
      rect.yb = std::min(height - 1, rect.ya + std::uniform_int_distribution<int>(0, largest)(rng));
      return rect;
    };
    for (int i = 0; i < 300; ++i) {
      const PixelRect rect = random_rect(40);
      for (int y = rect.ya; y <= rect.yb; ++y) {
        coverage.draw(y, Coverage::columns(rect));
        for (int x = rect.xa; x <= rect.xb; ++x) at(x, y) = 1;
      }
      const PixelRect asked = random_rect(i % 2 == 0 ? 4 : 100);
      bool all = true;
      for (int y = asked.ya; y <= asked.yb; ++y) {
        std::uint64_t open = 0;
        for (int x = asked.xa; x <= asked.xb; ++x) {
          open |= std::uint64_t{at(x, y) == 0} << x;
        }
        REQUIRE(coverage.open(y, Coverage::columns(asked)) == open);
        all = all && open == 0;
      }
      REQUIRE(coverage.covers(asked) == all);
    }
    for (int y = 0; y < height; ++y) {  // Outside the strip all counts as drawn.
      coverage.draw(y, Coverage::columns({0, y, width - 1, y}));
      REQUIRE(coverage.open(y, Coverage::kFull) == 0);
    }
  }
}

TEST_CASE("workers do each piece once, again and again", "[workers]") {
  for (const std::size_t count : {0u, 1u, 2u, 5u}) {
    Workers workers(count);
    REQUIRE(workers.count() == std::max<std::size_t>(count, 1));
    for (std::size_t pieces = 0; pieces < 60; ++pieces) {
      std::vector<std::atomic<int>> done(pieces);
      std::atomic<bool> strange{false};
      workers.run(pieces, [&](std::size_t piece, std::size_t worker) {
        ++done[piece];
        if (worker >= workers.count()) strange = true;
      });
      REQUIRE_FALSE(strange);
      for (const auto& times : done) REQUIRE(times == 1);
    }
  }
}

}  // namespace
}  // namespace voxatlas
