#include "grid/index_spec.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "grid/grid.hpp"

namespace voxatlas {
namespace {

TEST_CASE("the paper's standard parametrisation follows from 10 m and 0.1 m", "[grid]") {
  const auto spec = index_spec(10, 0.1);
  REQUIRE(spec.has_value());
  REQUIRE(spec->d_tile == 7);
  REQUIRE(spec->l_tile == 12.8);
  REQUIRE(spec->l_index == 12'800'000);
}

TEST_CASE("equations 1 to 4 hold for sizes worked out by hand", "[grid][oracle]") {
  struct Row {
    double r_tile, r_max;
    int d_tile;
    double l_tile, tiles;
  };
  const auto row = GENERATE(values<Row>({
      {12.8, 0.1, 7, 12.8, 1'000'000},    // Already a power of two: not one level more.
      {12.80001, 0.1, 8, 25.6, 500'000},  // A little above it: one more.
      {0.1, 0.1, 0, 0.1, 128'000'000},    // A tile of one cell.
      {10, 0.05, 8, 12.8, 1'000'000},     //
      {10, 1, 4, 16, 800'000},            //
      {100, 0.25, 9, 128, 100'000},       //
      {10, 0.3, 6, 19.2, 666'667},        // 666 666.67 tiles: rounded up.
      {1000, 0.7, 11, 1433.6, 8929},      // 8928.57 tiles.
      {12.8e6, 12.8e6, 0, 12.8e6, 1},     //
      {1e9, 1e9, 0, 1e9, 1},              // Larger than the Earth: one tile holds it.
      {0.125 * 1073741824, 0.125, 30, 0.125 * 1073741824, 1},  // The deepest.
  }));
  CAPTURE(row.r_tile, row.r_max);
  const auto spec = index_spec(row.r_tile, row.r_max);
  REQUIRE(spec.has_value());
  CHECK(spec->d_tile == row.d_tile);
  CHECK(spec->l_tile == Approx(row.l_tile).epsilon(1e-15));
  CHECK(spec->l_tile == edge_length(row.r_max, spec->d_tile));
  CHECK(spec->l_index == Approx(row.tiles * row.l_tile).epsilon(1e-14));
}

TEST_CASE("equations 1 to 4 give the sizes of every grid", "[grid]") {
  for (int k = 1; k <= 20; ++k) {
    CAPTURE(k);
    const auto grid = Grid::create(k);
    const auto spec = index_spec(100.0 / k, 1.0 / k);
    REQUIRE(spec.has_value());
    CHECK(spec->d_tile == kDepth);
    CHECK(spec->l_tile == Approx(grid->tile_length()).epsilon(1e-15));
    CHECK(spec->l_index == Approx(12.8e6).epsilon(1e-15));
    CHECK(spec->l_index / spec->l_tile == Approx(grid->tiles_per_axis()).epsilon(1e-15));
  }
}

TEST_CASE("d_tile is the least that reaches r_tile", "[grid][oracle]") {
  for (int i = 1; i <= 2000; ++i) {
    const double r_tile = i * 0.07;
    const auto spec = index_spec(r_tile, 0.07);
    int d = 0;
    while ((1 << d) < i) ++d;
    REQUIRE(spec.has_value());
    // 0.07 i is rounded, and may lie above or below the whole multiple: only powers are exact.
    REQUIRE(spec->d_tile == d);
  }
}

TEST_CASE("index_spec refuses what is no size, and names it", "[grid]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Row {
    double r_tile, r_max;
    const char* named;
  };
  const auto row = GENERATE_COPY(values<Row>({
      {10, 0, "r_max = 0"},
      {10, -0.1, "r_max = -0.1"},
      {10, nan, "r_max = nan"},
      {10, inf, "r_max = inf"},
      {nan, 0.1, "r_tile = nan"},
      {inf, 0.1, "r_tile = inf"},
      {-10, 0.1, "r_tile = -10"},
      {0.09, 0.1, "r_tile = 0.09"},
      {0.1 * 1073741825, 0.1, "d_tile above 30"},
      {1e300, 1e-300, "d_tile above 30"},
      {1e-300, 1e-300, "l_tile = 1e-300"},
      {1.7e308, 1e308, "l_tile = inf"},
  }));
  CAPTURE(row.r_tile, row.r_max);
  const auto spec = index_spec(row.r_tile, row.r_max);
  REQUIRE_FALSE(spec.has_value());
  REQUIRE(spec.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(spec.error().message, Catch::Contains(row.named));
}

}  // namespace
}  // namespace voxatlas
