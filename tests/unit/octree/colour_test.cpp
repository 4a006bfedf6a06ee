#include "octree/colour.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Oracle: the formula of DESIGN section 3 in doubles, halves away from zero as std::round does.
double mean_by_formula(double mean, double seen, double n) {
  return mean + std::round((256 * seen - mean) / n);
}

TEST_CASE("a colour's mean follows the formula, channel by channel", "[octree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 2000; ++round) {
    Colour colour;
    double means[3]{};
    for (int i = 1; i <= 40; ++i) {
      const Rgb seen{static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng() % 3),
                     static_cast<std::uint8_t>(255 - rng() % 2)};
      colour.add(seen);
      const int n = i < 16 ? i : 16;
      means[0] = mean_by_formula(means[0], seen.r, n);
      means[1] = mean_by_formula(means[1], seen.g, n);
      means[2] = mean_by_formula(means[2], seen.b, n);
      REQUIRE(colour.count == n);
      for (std::size_t c = 0; c < 3; ++c) REQUIRE(colour.mean[c] == means[c]);
    }
  }
}

TEST_CASE("one and the same colour seen again and again stays what it is", "[octree]") {
  for (int value = 0; value < 256; ++value) {
    const auto v = static_cast<std::uint8_t>(value);
    Colour colour;
    for (int i = 0; i < 20; ++i) colour.add({v, v, v});
    REQUIRE(colour.rgb() == Rgb{v, v, v});
    REQUIRE(colour.exists());
  }
  REQUIRE_FALSE(Colour{}.exists());
  REQUIRE(Colour{{65535, 0x7f80, 0x7f7f}, 1}.rgb() == Rgb{255, 128, 127});
}

}  // namespace
}  // namespace voxatlas
