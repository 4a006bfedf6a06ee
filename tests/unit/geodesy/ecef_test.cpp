#include "geodesy/ecef.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/engine.hpp"
#include "unit/geodesy/places.hpp"

namespace voxatlas {
namespace {

TEST_CASE("to_ecef agrees with the textbook's closed form", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 20'000; ++i) {
    const Geodetic place = test::any_place(rng);
    CAPTURE(place.latitude_deg, place.longitude_deg, place.height);
    const auto p_ecef = to_ecef(place);
    REQUIRE(p_ecef.has_value());
    REQUIRE((*p_ecef - test::ecef_by_closed_form(place)).norm() < 1e-8);
  }
}

TEST_CASE("to_ecef puts the axes' points where WGS 84 defines them", "[geodesy]") {
  const double b = 6'356'752.314'245;  // The semi-minor axis, as published, to a micrometre.
  struct Row {
    Geodetic place;
    Eigen::Vector3d p_ecef;
  };
  const Row rows[] = {
      {{0, 0, 0}, {6'378'137, 0, 0}},      {{0, 90, 0}, {0, 6'378'137, 0}},
      {{0, 180, 0}, {-6'378'137, 0, 0}},   {{0, -180, 0}, {-6'378'137, 0, 0}},
      {{0, -90, 100}, {0, -6'378'237, 0}}, {{90, 0, 0}, {0, 0, b}},
      {{90, 123, 0}, {0, 0, b}},           {{-90, 0, -50}, {0, 0, 50 - b}},
      {{0, 360, 0}, {6'378'137, 0, 0}},
  };
  for (const auto& row : rows) {
    const auto p_ecef = to_ecef(row.place);
    REQUIRE(p_ecef.has_value());
    CAPTURE(row.place.latitude_deg, row.place.longitude_deg);
    REQUIRE((*p_ecef - row.p_ecef).norm() < 1e-6);
  }
}

TEST_CASE("to_geodetic gives back what to_ecef was given", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 20'000; ++i) {
    const Geodetic place = test::any_place(rng);
    CAPTURE(place.latitude_deg, place.longitude_deg, place.height);
    const auto p_ecef = to_ecef(place);
    const auto back = to_geodetic(*p_ecef);
    REQUIRE(back.has_value());
    REQUIRE(std::abs(back->height - place.height) < 1e-8);
    REQUIRE(std::abs(back->latitude_deg - place.latitude_deg) < 1e-12);
    REQUIRE(std::abs(back->longitude_deg) <= 180);
    // Longitude in metres along the ground, so that the poles and the date line need no exception.
    const double turn = (back->longitude_deg - place.longitude_deg) * test::kPi / 180;
    REQUIRE(std::abs(std::sin(turn)) * std::hypot(p_ecef->x(), p_ecef->y()) < 1e-8);
    REQUIRE((*to_ecef(*back) - *p_ecef).norm() < 1e-8);
  }
}

TEST_CASE("to_geodetic is defined on the Earth's axis and at its centre", "[geodesy]") {
  const double z = GENERATE(6'356'752.0, -6'356'752.0, 1.0, 0.0);
  const auto place = to_geodetic({0, 0, z});
  REQUIRE(place.has_value());
  REQUIRE(std::abs(place->latitude_deg) == 90);
  REQUIRE(place->longitude_deg == 0);
  REQUIRE(std::isfinite(place->height));
}

TEST_CASE("what is no place is refused by name", "[geodesy]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Row {
    Geodetic place;
    const char* named;
  };
  const Row rows[] = {
      {{nan, 0, 0}, "latitude = nan"},  {{90.0001, 0, 0}, "latitude = 90.0001"},
      {{-91, 0, 0}, "latitude = -91"},  {{0, nan, 0}, "longitude = nan"},
      {{0, 361, 0}, "longitude = 361"}, {{0, -inf, 0}, "longitude = -inf"},
      {{0, 0, nan}, "height = nan"},    {{0, 0, inf}, "height = inf"},
  };
  for (const auto& row : rows) {
    const auto refused = to_ecef(row.place);
    REQUIRE_FALSE(refused.has_value());
    REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
    REQUIRE_THAT(refused.error().message, Catch::Contains(row.named));
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double bad : {nan, inf, -inf}) {
      Eigen::Vector3d p_ecef(1, 2, 3);
      p_ecef[axis] = bad;
      const auto refused = to_geodetic(p_ecef);
      REQUIRE_FALSE(refused.has_value());
      REQUIRE_THAT(refused.error().message,
                   Catch::StartsWith(std::string("ECEF ") + "xyz"[axis] + " = "));
    }
  }
}

TEST_CASE("up is the normal of the ellipsoid, at any height", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 5'000; ++i) {
    const Geodetic place = test::any_place(rng);
    const Eigen::Vector3d up = up_at(*to_ecef(place));
    REQUIRE(std::abs(up.norm() - 1) < 1e-14);
    // 1e-8 m of rounding in a position turn the normal by 1e-15 or so.
    REQUIRE((up - test::up_by_angles(place)).norm() < 1e-14);
  }
}

}  // namespace
}  // namespace voxatlas
