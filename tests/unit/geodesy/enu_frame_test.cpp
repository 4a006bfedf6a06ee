#include "geodesy/enu_frame.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>

#include "support/engine.hpp"
#include "unit/geodesy/places.hpp"

namespace voxatlas {
namespace {

TEST_CASE("an EnuFrame's axes are where the ground moves to", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 3'000; ++i) {
    Geodetic place = test::any_place(rng);
    place.latitude_deg *= 0.99;  // At the poles no way is east: the next test.
    CAPTURE(place.latitude_deg, place.longitude_deg, place.height);
    const auto frame = EnuFrame::at(place);
    REQUIRE(frame.has_value());

    // Oracle: differences of the closed form, one step of 1e-5 degrees or 1 m to either side.
    const auto moved = [&](double lat, double lon, double height) -> Eigen::Vector3d {
      const Eigen::Vector3d ahead = test::ecef_by_closed_form(
          {place.latitude_deg + lat, place.longitude_deg + lon, place.height + height});
      const Eigen::Vector3d behind = test::ecef_by_closed_form(
          {place.latitude_deg - lat, place.longitude_deg - lon, place.height - height});
      return (ahead - behind).normalized();
    };
    REQUIRE((frame->east_ecef() - moved(0, 1e-3, 0)).norm() < 1e-7);
    REQUIRE((frame->north_ecef() - moved(1e-3, 0, 0)).norm() < 1e-7);
    REQUIRE((frame->up_ecef() - moved(0, 0, 1)).norm() < 1e-7);
    REQUIRE((frame->up_ecef() - up_at(frame->origin_ecef())).norm() < 1e-14);
    REQUIRE((frame->origin_ecef() - test::ecef_by_closed_form(place)).norm() < 1e-8);
  }
}

TEST_CASE("an EnuFrame turns points there and back", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> metres(-5'000, 5'000);
  for (int i = 0; i < 3'000; ++i) {
    const auto frame = EnuFrame::at(test::any_place(rng));
    const Eigen::Vector3d p_enu(metres(rng), metres(rng), metres(rng));
    const Eigen::Vector3d p_ecef = frame->to_ecef(p_enu);
    REQUIRE((frame->to_enu(p_ecef) - p_enu).norm() < 1e-8);
    REQUIRE((p_ecef - frame->origin_ecef()).norm() == Approx(p_enu.norm()).epsilon(1e-10));
    REQUIRE(frame->to_enu(frame->origin_ecef()).norm() == 0);
    const Eigen::Vector3d summed = frame->origin_ecef() + frame->east_ecef() * p_enu.x() +
                                   frame->north_ecef() * p_enu.y() + frame->up_ecef() * p_enu.z();
    REQUIRE((p_ecef - summed).norm() < 1e-8);
  }
}

TEST_CASE("an EnuFrame by place and by point is the same", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 1'000; ++i) {
    Geodetic place = test::any_place(rng);
    place.latitude_deg *= 0.99;
    const auto by_place = EnuFrame::at(place);
    const auto by_point = EnuFrame::at(by_place->origin_ecef());
    REQUIRE(by_point.has_value());
    REQUIRE(by_point->origin_ecef() == by_place->origin_ecef());
    const Eigen::Matrix3d difference =
        by_point->ecef_from_enu().rotation() - by_place->ecef_from_enu().rotation();
    REQUIRE(difference.cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("an EnuFrame at a pole takes east from its longitude", "[geodesy]") {
  const double longitude = GENERATE(0.0, 90.0, 180.0, -45.0);
  const double pole = GENERATE(90.0, -90.0);
  const auto frame = EnuFrame::at(Geodetic{pole, longitude, 10});
  REQUIRE(frame.has_value());
  const double turn = longitude * test::kPi / 180;
  REQUIRE((frame->up_ecef() - Eigen::Vector3d(0, 0, pole / 90)).norm() < 1e-15);
  REQUIRE((frame->east_ecef() - Eigen::Vector3d(-std::sin(turn), std::cos(turn), 0)).norm() <
          1e-15);
  const auto by_point = EnuFrame::at(Eigen::Vector3d(0, 0, pole / 90 * 6'356'762));
  REQUIRE(by_point.has_value());
  REQUIRE((by_point->east_ecef() - Eigen::Vector3d(0, 1, 0)).norm() < 1e-15);
}

TEST_CASE("an EnuFrame refuses an origin that is not on the cube", "[geodesy]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto too_high = EnuFrame::at(Geodetic{0, 0, 30'000});
  REQUIRE_FALSE(too_high.has_value());
  REQUIRE(too_high.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(too_high.error().message, Catch::Contains("6408137"));
  REQUIRE_FALSE(EnuFrame::at(Geodetic{nan, 0, 0}).has_value());
  REQUIRE_FALSE(EnuFrame::at(Geodetic{95, 0, 0}).has_value());
  REQUIRE_FALSE(EnuFrame::at(Eigen::Vector3d(nan, 0, 0)).has_value());
  REQUIRE_FALSE(EnuFrame::at(Eigen::Vector3d(0, 6.4e6, 0)).has_value());
}

}  // namespace
}  // namespace voxatlas
