#include "sim/drive.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "geodesy/ecef.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Catch::Matchers::Contains;

const City& city() {
  static const City made = *City::create({});
  return made;
}

DriveOptions coarse() {
  DriveOptions options;
  options.azimuth_step_deg = 3;
  return options;
}

bool same(const SensorScan& a, const SensorScan& b) {
  return a.points_sensor == b.points_sensor && a.intensities == b.intensities &&
         a.colours == b.colours && a.ecef_from_sensor == b.ecef_from_sensor && a.utime == b.utime;
}

TEST_CASE("a scan is the same made twice, in any order, in a drive of any length", "[sim]") {
  DriveOptions options = coarse();
  const auto drive = Drive::create(city(), options);
  options.scans = 35'000;
  const auto lengthy = Drive::create(city(), options);
  std::map<std::size_t, SensorScan> made;
  for (const std::size_t i : {7u, 0u, 199u, 50u}) made.emplace(i, drive->simulate(i));
  for (const std::size_t i : {0u, 50u, 7u, 199u}) {
    REQUIRE(same(made.at(i), drive->simulate(i)));
    REQUIRE(same(made.at(i), lengthy->simulate(i)));
  }
  REQUIRE_FALSE(made.at(0).points_sensor == made.at(7).points_sensor);
}

TEST_CASE("without noise every point lies on a true surface and nothing stands before it",
          "[sim][oracle]") {
  DriveOptions options = coarse();
  options.sigma = 0;
  options.scans = 35'000;
  const auto drive = Drive::create(city(), options);
  for (std::size_t scan = 1; scan < options.scans; scan += 2'917) {
    const Instant now = drive->instant(scan);
    const Pose city_from_sensor = drive->city_from_sensor(scan);
    const SensorScan seen = drive->simulate(scan);
    REQUIRE(seen.points_sensor.size() > drive->beams_per_scan() / 2);
    for (std::size_t i = 0; i < seen.points_sensor.size(); i += 3) {
      const Eigen::Vector3d p_sensor = seen.points_sensor[i].cast<double>();
      const Eigen::Vector3d p_city = city_from_sensor * p_sensor;
      const double rounding = 1e-6 + p_sensor.norm() * 1e-7;  // Of float, across each axis.
      CAPTURE(scan, i, p_city.transpose());
      REQUIRE(std::abs(now.nearest(p_city, 0.5).distance) < rounding);
      REQUIRE((city().to_city(seen.ecef_from_sensor * p_sensor) - p_city).norm() < 1e-7);
    }
  }
}

TEST_CASE("the way to a point is free", "[sim][oracle]") {
  DriveOptions options = coarse();
  options.sigma = 0;
  const auto drive = Drive::create(city(), options);
  const Instant now = drive->instant(20);
  const Pose city_from_sensor = drive->city_from_sensor(20);
  const SensorScan seen = drive->simulate(20);
  for (std::size_t i = 0; i < seen.points_sensor.size(); i += 11) {
    const Eigen::Vector3d p_sensor = seen.points_sensor[i].cast<double>();
    for (double share = 0.02; share < 0.999; share += 0.02) {
      const auto nearest = now.nearest(city_from_sensor * (share * p_sensor), 0.3);
      REQUIRE(nearest.distance > -1e-6);
    }
  }
}

TEST_CASE("the noise on ranges has the deviation asked for", "[sim]") {
  DriveOptions options = coarse();
  const auto noisy = Drive::create(city(), options);
  options.sigma = 0;
  const auto exact = Drive::create(city(), options);
  double sum = 0, squares = 0, beyond = 0, count = 0;
  for (std::size_t scan = 0; scan < 8; ++scan) {
    const auto a = noisy->simulate(scan), b = exact->simulate(scan);
    REQUIRE(a.points_sensor.size() == b.points_sensor.size());
    for (std::size_t i = 0; i < a.points_sensor.size(); ++i) {
      const double off = double{a.points_sensor[i].norm()} - double{b.points_sensor[i].norm()};
      sum += off;
      squares += off * off;
      beyond += std::abs(off) > 0.04;
      ++count;
    }
  }
  REQUIRE(std::abs(sum / count) < 4 * 0.02 / std::sqrt(count));
  REQUIRE(std::sqrt(squares / count) == Approx(0.02).epsilon(0.02));
  REQUIRE(beyond / count == Approx(0.0455).margin(0.004));  // A gaussian's share beyond 2 sigma.
}

TEST_CASE("a drive starts near the campus and keeps its rate", "[sim]") {
  DriveOptions options;
  options.scans = 35'000;
  const auto drive = Drive::create(city(), options);
  REQUIRE(drive->scan_count() == 35'000);
  REQUIRE(drive->beams_per_scan() == 57'600);
  for (std::size_t scan = 0; scan < 35'000; scan += 500) {
    const auto place = to_geodetic(drive->ecef_from_sensor(scan).translation());
    REQUIRE(place.has_value());
    REQUIRE(std::abs(place->latitude_deg - 48.1489) < 0.004);
    REQUIRE(std::abs(place->longitude_deg - 11.5680) < 0.006);
    REQUIRE(std::abs(place->height - 560) < 15);
    REQUIRE(drive->utime(scan) == options.start_utime + static_cast<std::int64_t>(scan) * 50'000);
  }
  const auto a = drive->city_from_sensor(10).translation();
  const auto b = drive->city_from_sensor(30).translation();
  REQUIRE((b - a).norm() == Approx(8).epsilon(1e-3));  // One second on a straight.
}

TEST_CASE("each scanner is tilted by 25 degrees to its own side", "[sim]") {
  const auto drive = Drive::create(city(), {});
  const Eigen::Vector3d up(0, 0, 1);
  for (const std::size_t scan : {0u, 1u}) {
    const Eigen::Matrix3d r = drive->city_from_sensor(scan).rotation();
    const double degrees = std::acos(r.col(2).dot(up)) * 180 / 3.14159265358979;
    REQUIRE(degrees == Approx(25).margin(1.5));  // The ground is tilted by 1.3 degrees.
    REQUIRE((r.col(1).z() > 0) == (scan == 0));  // The left side of the left one looks up.
  }
}

TEST_CASE("no vehicle stands where the scanning car is", "[sim]") {
  DriveOptions options;
  options.scans = 35'000;
  const auto drive = Drive::create(city(), options);
  for (std::size_t scan = 0; scan < 35'000; scan += 250) {
    const Instant now = drive->instant(scan);
    const Eigen::Vector3d p = drive->city_from_sensor(scan).translation();
    REQUIRE(now.nearest(p, 5).distance > 0.3);
    REQUIRE(now.nearest({p.x(), p.y(), p.z() - 1.5}, 5).distance > 0.3);
  }
}

TEST_CASE("options that no scanner could have are refused by name and value", "[sim]") {
  DriveOptions options;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SECTION("scans") { options.scans = 0; }
  SECTION("azimuth") { options.azimuth_step_deg = 0; }
  SECTION("sigma") { options.sigma = nan; }
  SECTION("range") { options.max_range = -1; }
  SECTION("speed") { options.speed = 1e9; }
  SECTION("start") { options.start_utime = -5; }
  const auto drive = Drive::create(city(), options);
  REQUIRE_FALSE(drive.has_value());
  REQUIRE(drive.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(drive.error().message, Contains("drive: ") && Contains(" is "));
}

}  // namespace
}  // namespace voxatlas
