#include "integrate/integrator.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"
#include "unit/integrate/scan_oracle.hpp"

namespace voxatlas {
namespace {

using test::cells_by_sorting;
using test::cells_of;

constexpr double kMetre = 1;

/// A scan of few rays, standard grid.
Scan scan_of(const Eigen::Vector3d& origin, std::vector<Eigen::Vector3d> endpoints) {
  Scan scan;
  scan.origin_ecef = origin;
  scan.endpoints_ecef = std::move(endpoints);
  scan.sigma = 0.02;
  return scan;
}

test::ScanCells integrated(const Scan& scan, const IntegrationParameters& parameters,
                           const Grid& grid = Grid::standard()) {
  auto delta = Integrator(grid, parameters).integrate(scan);
  REQUIRE(delta.has_value());
  return cells_of(*delta);
}

void require_equal(test::ScanCells ours, const test::ScanCells& oracle) {
  // A delta without cells says nothing of its depths.
  ours.miss_depth = oracle.miss_depth;
  if (ours.hits.empty()) ours.hit_depth = oracle.hit_depth;
  REQUIRE(ours.misses.size() == oracle.misses.size());
  REQUIRE((ours == oracle));  // In brackets: Catch2 would print every cell.
}

TEST_CASE("a scan's cells are those of sorted border crossings, for all depths of misses and hits",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const int free_depth = GENERATE(range(-1, 8));
  const int surface_depth = GENERATE(range(0, 8));
  const int k = std::array{10, 10, 1, 20, 7}[rng() % 5];
  const auto grid = *Grid::create(k);
  const double tile = grid.tile_length();
  const bool all_rays_free = rng() % 2 == 0;
  Integrator integrator(grid, {free_depth, surface_depth, 0.1 * tile, 1.2 * tile, all_rays_free});
  for (int i = 0; i < 12; ++i) {
    // Around a tile's corner, on the Earth and where coordinates change their sign.
    const Eigen::Vector3d corner =
        tile * (i % 3 == 0 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(324'000, 48'000, -370'000));
    auto scan = test::ScanMaker{corner, tile, k, 40, i % 2 == 0}(rng);
    scan.sigma = tile / (4 << rng() % 8);
    if (i % 4 == 0) scan.min_range = 0.3 * tile;
    CAPTURE(free_depth, surface_depth, k, i, scan.sigma);
    auto delta = integrator.integrate(scan);
    REQUIRE(delta.has_value());
    require_equal(cells_of(*delta),
                  cells_by_sorting(
                      scan, {free_depth, surface_depth, 0.1 * tile, 1.2 * tile, all_rays_free}, k));
  }
}

TEST_CASE("a ray marks its origin's cell as missed and its end's as hit", "[integrate]") {
  const auto cells = integrated(scan_of({10.05, 0.05, 0.05}, {{10.45, 0.05, 0.05}}), {7, 7, 0, 10});
  REQUIRE(cells.hits.size() == 1);
  REQUIRE(cells.misses.size() == 4);
  REQUIRE(cells.hits.begin()->at(0) == 64'000'104);
  REQUIRE(cells.misses.begin()->at(0) == 64'000'100);
}

TEST_CASE("a ray beyond max_range only frees, up to it, and leaves its end cell alone",
          "[integrate]") {
  const auto cells = integrated(scan_of({0.05, 0.05, 0.05}, {{50.05, 0.05, 0.05}}), {7, 7, 0, 10});
  REQUIRE(cells.hits.empty());
  REQUIRE(cells.beyond_max == 1);
  REQUIRE(cells.misses.size() == 100);
  REQUIRE(cells.misses.rbegin()->at(0) == 64'000'099);
}

TEST_CASE("a ray of no length is a hit and nothing else", "[integrate]") {
  const Eigen::Vector3d p(4.1e6, 6e5, 4.7e6);
  const auto cells = integrated(scan_of(p, {p}), {});
  REQUIRE(cells.hits.size() == 1);
  REQUIRE(cells.misses.empty());
}

TEST_CASE("a miss that equals, contains or lies inside a hit of another tile's ray is dropped",
          "[integrate]") {
  // Two rays through one tile border: the second passes the cell the first one ends in.
  const auto scan = scan_of({-0.05, 0.05, 0.05}, {{0.35, 0.05, 0.05}, {0.95, 0.05, 0.05}});
  const int free_depth = GENERATE(7, 6, 5);
  const auto cells = integrated(scan, {free_depth, 7, 0, 10});
  const int shift = kDepth - free_depth;
  REQUIRE(cells.hits.size() == 2);
  for (const auto& hit : cells.hits) {
    REQUIRE_FALSE(cells.misses.contains({hit[0] >> shift, hit[1] >> shift, hit[2] >> shift}));
  }
  REQUIRE_FALSE(cells.misses.empty());
}

TEST_CASE("a cell's colour is the mean of its points, halves rounded up", "[integrate]") {
  const Eigen::Vector3d p(1.05, 1.05, 1.05);
  auto scan = scan_of({5.05, 5.05, 5.05}, {p, p});
  scan.colours.push_back({0, 255, 7});
  scan.colours.push_back({1, 254, 7});
  const auto cells = integrated(scan, {});
  REQUIRE(cells.colours.size() == 1);
  REQUIRE(cells.colours.begin()->second == std::array<int, 3>{1, 255, 7});
}

TEST_CASE("the same scan gives the same delta from a fresh and from a used integrator",
          "[integrate]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto grid = Grid::standard();
  Integrator used(grid, {});
  for (int i = 0; i < 20; ++i) {
    auto scan = test::ScanMaker{{4.1e6, 6e5, 4.7e6}, 60, 10, 50, i % 2 == 0}(rng);
    scan.sigma = 0.0125 * (1 << rng() % 8);
    const auto again = used.integrate(scan);
    const auto once = Integrator(grid, {}).integrate(scan);
    REQUIRE((again->tiles == once->tiles));
  }
}

TEST_CASE("an integrator refuses a scan as a whole, naming the value", "[integrate]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  Integrator integrator(Grid::standard(), {});
  auto scan = scan_of({0, 0, 0}, {{1, 1, 1}});
  SECTION("sigma") { scan.sigma = GENERATE_COPY(0.0, -1.0, nan, infinity, 3.21); }
  SECTION("origin") { scan.origin_ecef.y() = GENERATE_COPY(6.4e6, -6.4000001e6, nan, -infinity); }
  SECTION("colours") { scan.colours = std::vector<Rgb>(2); }
  SECTION("min_range") { scan.min_range = GENERATE_COPY(-0.1, nan); }
  const auto delta = integrator.integrate(scan);
  REQUIRE_FALSE(delta.has_value());
  REQUIRE(delta.error().code == ErrorCode::kOutOfRange);
  REQUIRE_FALSE(delta.error().message.empty());
}

TEST_CASE("an endpoint that is hostile costs no more than max_range and is counted",
          "[integrate]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto scan = scan_of({4e6, 0, 0}, {{nan, 0, 0},
                                          {0, infinity, 0},
                                          {0, 0, -infinity},
                                          {1e7, 1e7, 1e7},
                                          {-1e7, 0, 0},
                                          {1.7e308, -1.7e308, 1.7e308},
                                          {5e-324, 0, 0}});
  const IntegrationParameters parameters{7, 7, 0, 120};
  const auto cells = integrated(scan, parameters);
  require_equal(cells, cells_by_sorting(scan, parameters, 10));
  REQUIRE(cells.not_finite == 3);
  REQUIRE(cells.beyond_max == 4);
}

TEST_CASE("the faces of the index cube belong to it below and not above", "[integrate]") {
  const double face = 6.4e6;
  const double inside = std::nextafter(face, 0.0);
  const auto scan = scan_of({face - kMetre, -face, 0}, {{inside, -face, 0},
                                                        {face, -face, 0},
                                                        {face - kMetre, -face, inside},
                                                        {face - kMetre, -face - 1e-3, 0},
                                                        {face + 1e6, -face, 0},
                                                        {face - kMetre, -face + 0.55, 0}});
  const IntegrationParameters parameters{GENERATE(7, 4), 7, 0, 120};
  const auto cells = integrated(scan, parameters);
  require_equal(cells, cells_by_sorting(scan, parameters, 10));
  REQUIRE(cells.rays_hit == 2);
  REQUIRE(cells.beyond_max == 1);
  REQUIRE(cells.off_cube == 3);
}

TEST_CASE("a million equal points are one hit", "[integrate]") {
  auto scan = scan_of({4e6, 0, 0}, std::vector<Eigen::Vector3d>(1'000'000, {4e6, 3.33, 0}));
  scan.colours.assign(scan.endpoints_ecef.size(), {200, 100, 50});
  const auto cells = integrated(scan, {});
  REQUIRE(cells.rays_hit == 1'000'000);
  REQUIRE(cells.hits.size() == 1);
  REQUIRE(cells.colours.begin()->second == std::array<int, 3>{200, 100, 50});
}

TEST_CASE("parameters out of their ranges are refused by name", "[integrate]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  IntegrationParameters parameters;
  REQUIRE(parameters.check().has_value());
  SECTION("free_depth") { parameters.free_depth = GENERATE(-2, 8); }
  SECTION("surface_depth") { parameters.surface_depth = GENERATE(-1, 8); }
  SECTION("min_range") { parameters.min_range = GENERATE_COPY(-0.1, nan, 120.0); }
  SECTION("max_range") { parameters.max_range = GENERATE_COPY(0.0, nan, 1000.1, 1e300); }
  const auto status = parameters.check();
  REQUIRE(status.error().code == ErrorCode::kOutOfRange);
  REQUIRE(status.error().message.find("range") + status.error().message.find("depth") > 0);
}

}  // namespace
}  // namespace voxatlas
