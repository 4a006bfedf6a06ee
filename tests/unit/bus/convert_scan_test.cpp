#include "bus/convert_scan.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "geodesy/ecef.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

SensorScan random_scan(std::mt19937_64& rng, std::size_t points, bool coloured) {
  std::normal_distribution<float> spread(0, 30);
  SensorScan scan;
  scan.utime = static_cast<std::int64_t>(rng() >> 2);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::UnitRandom();
  scan.ecef_from_sensor = Pose::from_quaternion(turn, to_ecef({48.1, 11.5, 500}).value()).value();
  for (std::size_t i = 0; i < points; ++i) {
    scan.points_sensor.emplace_back(spread(rng), spread(rng), spread(rng));
    if (coloured) {
      scan.colours.push_back({static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng()),
                              static_cast<std::uint8_t>(rng())});
    }
  }
  return scan;
}

TEST_CASE("a scan is the same in ECEF whether it went over the wire or not", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 20; ++round) {
    const SensorScan seen = random_scan(rng, rng() % 500, round % 2 == 0);
    const Scan expected =
        to_scan(seen, 0.025, 2.5);  // 0.025: a border of eq. (5), exact in double.

    const auto message =
        decode_message<scan_t>(encode_message(to_message(seen, {"car", 1, round}, 0.025, 2.5)));
    REQUIRE(message.has_value());
    const auto got = to_scan(*message);

    REQUIRE(got.has_value());
    REQUIRE(got->origin_ecef == expected.origin_ecef);
    REQUIRE(got->endpoints_ecef == expected.endpoints_ecef);
    REQUIRE(got->colours == expected.colours);
    REQUIRE(got->sigma == expected.sigma);
    REQUIRE(got->min_range == expected.min_range);
    REQUIRE(got->utime == expected.utime);
    REQUIRE(identity_of(*message).value() == ScanIdentity{"car", 1, round});
  }
}

TEST_CASE("a scan is cut into as few parts as fit a datagram each", "[bus]") {
  auto rng = test::engine();
  const SensorScan seen = random_scan(rng, 20'000, true);
  const auto parts = to_parts(to_message(seen, {"car", 1, 0}, 0.02, 0));
  REQUIRE(parts.has_value());
  REQUIRE(parts->size() == 6);  // 300 000 bytes of points.
  std::int32_t count = 0;
  for (const auto& part : *parts) {
    REQUIRE(part.getEncodedSize() <= 60'000);
    REQUIRE(part.size == part.count * 15);
    count += part.count;
  }
  REQUIRE(count == 20'000);
  REQUIRE(to_parts(to_message(random_scan(rng, 0, false), {"car", 1, 0}, 0.02, 0))->size() == 1);
  REQUIRE(
      to_parts(to_message(random_scan(rng, 400'000, false), {"car", 1, 0}, 0.02, 0)).error().code ==
      ErrorCode::kOutOfRange);
}

TEST_CASE("a scan whose pose or sizes cannot be is refused", "[bus]") {
  auto rng = test::engine();
  scan_t message = to_message(random_scan(rng, 10, true), {"car", 1, 0}, 0.02, 0);
  SECTION("no rotation") { message.ecef_from_sensor[0] = 3; }
  SECTION("NaN") { message.ecef_from_sensor[3] = std::numeric_limits<double>::quiet_NaN(); }
  SECTION("off the Earth") { message.ecef_from_sensor[3] = 7e6; }
  SECTION("count") { message.count = 11; }
  SECTION("negative count") { message.count = -1; }
  SECTION("colour flag") { message.coloured = 0; }
  REQUIRE_FALSE(to_scan(message).has_value());
}

TEST_CASE("an identity is bounded", "[bus]") {
  auto rng = test::engine();
  scan_t message = to_message(random_scan(rng, 1, false), {"car", 1, 0}, 0.02, 0);
  REQUIRE(identity_of(message).has_value());
  SECTION("no source") { message.source.clear(); }
  SECTION("long source") { message.source.assign(65, 'x'); }
  SECTION("session") { message.session = -1; }
  SECTION("seq") { message.seq = -1; }
  REQUIRE(identity_of(message).error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
