#include "sim/solid_grid.hpp"

#include <catch2/catch.hpp>

#include "random_solids.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

std::vector<Solid> many_solids(std::mt19937_64& rng, int count) {
  std::vector<Solid> solids;
  for (int i = 0; i < count; ++i) solids.push_back(test::any_solid(rng, i, 12));
  return solids;
}

TEST_CASE("a SolidGrid finds the hit that trying every solid finds", "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const SolidGrid grid(many_solids(rng, 400), 1.5);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector3d from = test::point_in(rng, 20), to = test::unit_vector(rng);
    if (i % 4 == 0)
      to = i % 8 == 0 ? -Eigen::Vector3d::Unit(i / 8 % 3)
                      : Eigen::Vector3d(Eigen::Vector3d::Unit(i / 8 % 3));
    if (i % 6 == 0) from = grid.solids()[rng() % 400].min;  // On a border of something.
    const double limit = i % 5 == 0 ? test::between(rng, 0, 20) : 100;
    const Beam beam(from, to);
    double nearest = kNoHit;
    for (const Solid& solid : grid.solids()) {
      if (const double t = entry(solid, beam); t < limit) nearest = std::min(nearest, t);
    }
    const auto hit = grid.first_hit(beam, limit);
    CAPTURE(i);
    REQUIRE(hit.t == nearest);
    REQUIRE((hit.solid != nullptr) == (nearest != kNoHit));
    hits += hit.solid != nullptr;
  }
  REQUIRE(hits > 4000);
}

TEST_CASE("a SolidGrid finds the nearest that trying every solid finds", "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const SolidGrid grid(many_solids(rng, 400), 1.5);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p = test::point_in(rng, 14);
    const double limit = test::between(rng, 0, 4);
    double nearest = kNoHit;
    for (const Solid& solid : grid.solids()) {
      if (const double d = signed_distance(solid, p); d < limit) nearest = std::min(nearest, d);
    }
    REQUIRE(grid.nearest(p, limit).t == nearest);
  }
}

TEST_CASE("an empty SolidGrid has nothing to hit", "[sim]") {
  const SolidGrid grid({}, 2);
  REQUIRE(grid.first_hit(Beam({0, 0, 0}, {1, 0, 0}), 10).solid == nullptr);
  REQUIRE(grid.nearest({0, 0, 0}, 10).t == kNoHit);
}

}  // namespace
}  // namespace voxatlas
