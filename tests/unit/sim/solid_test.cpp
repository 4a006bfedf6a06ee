#include "sim/solid.hpp"

#include <catch2/catch.hpp>

#include "random_solids.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using test::holds;

TEST_CASE("a beam enters a solid where a walk in small steps first finds itself inside",
          "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  constexpr double kStep = 1e-3;
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Solid solid = test::any_solid(rng, i, 1);
    const Eigen::Vector3d from = test::point_in(rng, 3);
    Eigen::Vector3d to = (test::point_in(rng, 1) - from).normalized();
    if (i % 8 < 4) to = Eigen::Vector3d::Unit(static_cast<int>(rng() % 3));  // Along an axis.
    const Beam beam(from, to);
    double walked = kNoHit;
    for (double t = 0; t < 7 && walked == kNoHit; t += kStep) {
      if (holds(solid, beam.at(t))) walked = t;
    }
    const double t = entry(solid, beam);
    CAPTURE(i, t, walked);
    if (walked != kNoHit) {
      REQUIRE(t <= walked + 1e-9);
      REQUIRE(t >= walked - kStep - 1e-9);
      ++hits;
    } else if (t != kNoHit) {  // Through an edge, between two steps.
      REQUIRE(std::abs(signed_distance(solid, beam.at(t + kStep / 2))) < kStep);
    }
  }
  REQUIRE(hits > 200);
}

TEST_CASE("a solid is negative inside, zero where beams enter, positive outside", "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 20000; ++i) {
    const Solid solid = test::any_solid(rng, i, 0.5);
    const Eigen::Vector3d p = test::point_in(rng, 1.5);
    REQUIRE((signed_distance(solid, p) <= 0) == holds(solid, p));
    const Beam beam(p, test::unit_vector(rng));
    const double t = entry(solid, beam);
    if (t != kNoHit && t > 0) REQUIRE(std::abs(signed_distance(solid, beam.at(t))) < 1e-12);
  }
}

TEST_CASE("the distance to a solid is that of the nearest of many points of its surface",
          "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 24; ++i) {
    const Solid solid = test::any_solid(rng, i, 0.5);
    const Eigen::Vector3d p = test::point_in(rng, 1.5);
    const double distance = signed_distance(solid, p);
    double nearest = kNoHit;  // Beams from far away, through the solid: entries are its surface.
    for (int beam_number = 0; beam_number < 40000; ++beam_number) {
      const Eigen::Vector3d in_box =
          solid.min + (solid.max - solid.min)
                          .cwiseProduct(0.5 * (test::point_in(rng, 1) + Eigen::Vector3d::Ones()));
      const Eigen::Vector3d direction = test::unit_vector(rng);
      const Beam beam(in_box - 5 * direction, direction);
      if (const double t = entry(solid, beam); t != kNoHit) {
        nearest = std::min(nearest, (beam.at(t) - p).norm());
      }
    }
    CAPTURE(i, distance, nearest);
    REQUIRE(nearest >= std::abs(distance) - 1e-9);
    REQUIRE(nearest <= std::abs(distance) + 0.1);
  }
}

}  // namespace
}  // namespace voxatlas
