#include "integrate/quality.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST_CASE("the depth of integration is exact at every border, whatever the tile's length",
          "[integrate]") {
  const int k = GENERATE(range(1, 21));
  const double tile_length = 128.0 / k;
  for (int depth = 0; depth <= 7; ++depth) {
    const double border = tile_length / (4 << depth);
    CAPTURE(k, depth, border);
    REQUIRE(integration_depth(border, tile_length) == depth);
    REQUIRE(integration_depth(std::nextafter(border, 0.0), tile_length) == depth);
    const auto coarser = integration_depth(std::nextafter(border, kInfinity), tile_length);
    if (depth > 0) {
      REQUIRE(coarser == depth - 1);
    } else {
      REQUIRE(coarser.error().code == ErrorCode::kOutOfRange);
    }
  }
}

TEST_CASE("the depth of integration is what the paper's examples say", "[integrate]") {
  REQUIRE(integration_depth(0.025, 12.8) == 7);
  REQUIRE(integration_depth(0.0250001, 12.8) == 6);
  REQUIRE(integration_depth(0.05, 12.8) == 6);
  REQUIRE(integration_depth(0.1, 12.8) == 5);
  REQUIRE(integration_depth(0.5, 12.8) == 2);
  REQUIRE(integration_depth(3.2, 12.8) == 0);
  REQUIRE(integration_depth(1e-300, 12.8) == 7);
  REQUIRE(integration_depth(std::numeric_limits<double>::denorm_min(), 12.8) == 7);
}

TEST_CASE("the depth of integration agrees with equation (5) in long double between the borders",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> exponent(-7, 1.6);
  for (int i = 0; i < 100'000; ++i) {
    const double sigma = std::exp2(exponent(rng));
    const long double by_logarithm = std::floor(std::log2(12.8L / (4 * sigma)));
    CAPTURE(sigma);
    REQUIRE(integration_depth(sigma, 12.8) == static_cast<int>(std::min(by_logarithm, 7.0L)));
  }
}

TEST_CASE("a standard deviation that says nothing is refused by its value", "[integrate]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double sigma = GENERATE_COPY(0.0, -0.0, -0.025, nan, kInfinity, -kInfinity, 3.3, 1e308);
  const auto depth = integration_depth(sigma, 12.8);
  REQUIRE_FALSE(depth.has_value());
  REQUIRE(depth.error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
