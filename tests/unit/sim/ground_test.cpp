#include "sim/ground.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "random_solids.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a beam meets the ground where a walk in small steps first goes below it",
          "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  constexpr double kStep = 2e-3;
  int curbs = 0;
  for (int i = 0; i < 3000; ++i) {
    // Low over the street beside a curb, looking almost level: what a curb makes hard.
    const double across = Ground::kHalfRoad + test::between(rng, -3, 3);
    Eigen::Vector3d from(across, test::between(rng, -60, 60), 0);
    if (i % 2 == 0) from.head<2>() = from.head<2>().reverse().eval();
    from.z() = Ground::height(from.x(), from.y()) + test::between(rng, 0.01, 1);
    Eigen::Vector3d to = test::unit_vector(rng);
    to.z() *= 0.1;
    const Beam beam(from, to.normalized());
    double walked = kNoHit;
    for (double t = 0; t < 10 && walked == kNoHit; t += kStep) {
      const Eigen::Vector3d p = beam.at(t);
      if (p.z() < Ground::height(p.x(), p.y())) walked = t;
    }
    const auto hit = Ground::first_hit(beam, 10);
    CAPTURE(i, hit.t, walked);
    if (walked != kNoHit) {
      REQUIRE(hit.t <= walked);
      if (hit.t < walked - kStep - 1e-9) {  // It cut a corner between two steps.
        REQUIRE(std::abs(Ground::signed_distance(beam.at(hit.t + kStep / 2))) < kStep);
      }
    }
    if (hit.t != kNoHit) {
      REQUIRE(std::abs(Ground::signed_distance(beam.at(hit.t))) < 1e-9);
      curbs += hit.material == Material::kCurb;
    }
  }
  REQUIRE(curbs > 60);
}

TEST_CASE("the distance to the ground is that of the nearest of many points of it",
          "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 200; ++i) {
    const double curb = Ground::kHalfRoad;
    const double x = curb + test::between(rng, -0.6, 0.6), y = 30 + test::between(rng, -0.3, 0.3);
    const Eigen::Vector3d p(x, y, Ground::plane(x, y) + test::between(rng, -0.3, 0.5));
    double nearest = kNoHit;
    for (double dx = -1; dx <= 1; dx += 0.02) {
      for (double dy = -1; dy <= 1; dy += 0.02) {
        const Eigen::Vector3d q(x + dx, y + dy, Ground::height(x + dx, y + dy));
        nearest = std::min(nearest, (p - q).norm());
      }
    }
    for (double dy = -1; dy <= 1; dy += 0.02) {  // The curb's face.
      for (double up = 0; up <= Ground::kCurb; up += 0.02) {
        nearest = std::min(
            nearest, (p - Eigen::Vector3d(curb, y + dy, Ground::plane(curb, y + dy) + up)).norm());
      }
    }
    const double distance = Ground::signed_distance(p);
    CAPTURE(i, p.transpose());
    REQUIRE(std::abs(distance) <= nearest + 1e-9);
    REQUIRE(std::abs(distance) >= nearest - 0.02);
    REQUIRE((distance < 0) == (p.z() < Ground::height(x, y)));
  }
}

TEST_CASE("the ground is tilted, with blocks a curb above the streets", "[sim]") {
  REQUIRE(Ground::height(0, 0) == 0);
  REQUIRE(Ground::height(75, 0) == Approx(75 * Ground::kSlopeX));
  REQUIRE(Ground::height(37.5, 37.5) - Ground::plane(37.5, 37.5) == Approx(Ground::kCurb));
  REQUIRE(Ground::look(37.5, 37.5).material == Material::kGrass);
  REQUIRE(Ground::look(1, 37.5).material == Material::kAsphalt);
  REQUIRE(Ground::look(0, 37.5).material == Material::kMarking);
  REQUIRE(Ground::look(Ground::kHalfRoad + 1, 37.5).material == Material::kPavement);
  REQUIRE(Ground::look(0, 400).material == Material::kGrass);
}

}  // namespace
}  // namespace voxatlas
