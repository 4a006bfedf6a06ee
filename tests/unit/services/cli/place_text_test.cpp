#include "cli/place_text.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <random>

#include "geodesy/ecef.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a place is the three numbers that C reads in its text", "[cli][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> latitude(-90, 90), longitude(-360, 360),
      height(-500, 9000);
  for (int i = 0; i < 2'000; ++i) {
    const auto text =
        i % 2 == 0 ? fmt::format("{},{},{}", latitude(rng), longitude(rng), height(rng))
                   : fmt::format("{:.4f},{:.0f},{:e}", latitude(rng), longitude(rng), height(rng));
    CAPTURE(text);
    Geodetic expected;
    REQUIRE(std::sscanf(text.c_str(), "%lf,%lf,%lf", &expected.latitude_deg,
                        &expected.longitude_deg, &expected.height) == 3);

    const auto place = parse_place("--at", text);

    REQUIRE(place.has_value());
    REQUIRE(place->latitude_deg == expected.latitude_deg);
    REQUIRE(place->longitude_deg == expected.longitude_deg);
    REQUIRE(place->height == expected.height);
  }
}

TEST_CASE("what is no place is refused with the option and the text", "[cli]") {
  const std::string text = GENERATE("", "49", "49,8", "49,8,", ",,", "49,8,112,5", "49 8 112",
                                    "49, 8,112", "49,8,112m", "a,b,c", "49;8;112", "+49,8,1e999");
  const auto place = parse_place("--origin", text);
  REQUIRE_FALSE(place.has_value());
  REQUIRE(place.error().code == ErrorCode::kInvalid);
  REQUIRE(place.error().message.find("--origin " + text) != std::string::npos);
}

TEST_CASE("a place that is no number is refused where it is used", "[cli]") {
  const auto place = parse_place("--at", GENERATE("nan,8,112", "49,inf,112", "91,8,112"));
  REQUIRE(place.has_value());  // It is text of the right shape; what lies on Earth, geodesy knows.
  REQUIRE_FALSE(to_ecef(*place).has_value());
}

TEST_CASE("a box has its lower corner first, whichever two were given", "[cli]") {
  const auto box = parse_box("--box", "1,20,-3,4,-5,6.5").value();
  REQUIRE(box.min == Eigen::Vector3d(1, -5, -3));
  REQUIRE(box.max == Eigen::Vector3d(4, 20, 6.5));
}

TEST_CASE("what is no box is refused with the option and the text", "[cli]") {
  const std::string text = GENERATE("", "1,2,3", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,4,5,nan",
                                    "1,2,3,4,5,inf", "1,2,3 4,5,6", "a,b,c,d,e,f");
  const auto box = parse_box("--box", text);
  REQUIRE_FALSE(box.has_value());
  REQUIRE(box.error().code == ErrorCode::kInvalid);
  REQUIRE(box.error().message.find("--box " + text) != std::string::npos);
}

}  // namespace
}  // namespace voxatlas
