#include "sim/drive.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string_view>

#include "base/check.hpp"
#include "sim/ground.hpp"
#include "sim/random.hpp"

namespace voxatlas {
namespace {

constexpr int kBeams = 64;
constexpr double kLowestDeg = -24.8, kHighestDeg = 2;
constexpr double kTiltDeg = 25;
constexpr double kRadians = std::numbers::pi / 180;
constexpr double kHalfLength = 2.4, kHalfWidth = 0.95;  // Of the scanning car.
const Eigen::Vector3d kLeftMount(0.8, 0.6, 2.2);        // In the car: forward, left, up.

Status check_range(std::string_view what, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("drive: {} is {}, not {} to {}", what, value, low, high));
}

/// How strongly a material throws light back, as scanners report it.
float reflectance(Material material) {
  constexpr float kOf[] = {0.15f, 0.8f,  0.35f, 0.4f,  0.45f, 0.5f,  0.1f,
                           0.3f,  0.35f, 0.25f, 0.45f, 0.7f,  0.55f, 0.05f};
  return kOf[static_cast<std::size_t>(material)];
}

Pose must(Result<Pose> pose) {
  VOX_CHECK(pose.has_value());  // The city stands on the Earth and its rotations are made here.
  return *pose;
}

/// The scanner on the left looks up to the left, the one on the right to the right.
Pose car_from_sensor(std::size_t scanner) {
  const double side = scanner == 0 ? 1 : -1;
  const double c = std::cos(kTiltDeg * kRadians), s = side * std::sin(kTiltDeg * kRadians);
  Eigen::Matrix3d tilt;
  tilt << 1, 0, 0, 0, c, -s, 0, s, c;
  return must(Pose::create(tilt, {kLeftMount.x(), side * kLeftMount.y(), kLeftMount.z()}));
}

}  // namespace

Result<Drive> Drive::create(const City& city, const DriveOptions& options) {
  for (auto status : {check_range("number of scans", static_cast<double>(options.scans), 1, 1e7),
                      check_range("azimuth step in degrees", options.azimuth_step_deg, 0.05, 10),
                      check_range("sigma in metres", options.sigma, 0, 1),
                      check_range("range in metres", options.max_range, 1, 1000),
                      check_range("speed in metres a second", options.speed, 0, 50),
                      check_range("start in unix microseconds",
                                  static_cast<double>(options.start_utime), 0, 1e17)}) {
    if (!status) return pass_on(status);
  }
  return Drive(city, options);
}

Drive::Drive(const City& city, const DriveOptions& options)
    : city_(city),
      options_(options),
      route_(options.seed, options.speed * 0.05 * static_cast<double>(options.scans)) {
  const auto steps = std::lround(360 / options.azimuth_step_deg);
  for (long i = 0; i < steps; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(steps);
    azimuths_.push_back({std::cos(angle), std::sin(angle)});
  }
  for (int i = 0; i < kBeams; ++i) {
    const double angle = kRadians * (kLowestDeg + (kHighestDeg - kLowestDeg) * i / (kBeams - 1));
    elevations_.push_back({std::cos(angle), std::sin(angle)});
  }
}

std::int64_t Drive::utime(std::size_t scan) const {
  return options_.start_utime + 50'000 * static_cast<std::int64_t>(scan);
}

Pose Drive::city_from_car(std::size_t scan) const {
  const Route::Place place = route_.at(options_.speed * seconds(scan));
  const double x = place.p.x(), y = place.p.y();
  const double dx = std::cos(place.heading), dy = std::sin(place.heading);
  Eigen::Matrix3d rotation;  // Its wheels are on the tilted ground.
  rotation.col(2) = Ground::normal();
  rotation.col(0) = Eigen::Vector3d(dx, dy, Ground::plane(dx, dy)).normalized();
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return must(Pose::create(rotation, {x, y, Ground::plane(x, y)}));
}

Pose Drive::city_from_sensor(std::size_t scan) const {
  return must(city_from_car(scan) * car_from_sensor(scan % 2));
}

Pose Drive::ecef_from_sensor(std::size_t scan) const {
  return must(city_.ecef_from_city() * city_from_sensor(scan));
}

Instant Drive::instant(std::size_t scan) const {
  const Pose car = city_from_car(scan);
  const Eigen::Vector2d forward = car.rotation().col(0).head<2>().normalized();
  return Instant(city_, seconds(scan),
                 KeptClear{car.translation().head<2>(), forward, kHalfLength, kHalfWidth});
}

double Drive::noise(std::size_t scan, std::size_t beam) const {
  const std::uint64_t bits = mix(mix(mix(options_.seed) ^ scan) ^ beam);
  const double u = (static_cast<double>(bits >> 32) + 0.5) * 0x1p-32;
  const double v = static_cast<double>(bits & 0xffff'ffff) * 0x1p-32;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);  // Box and Muller.
}

SensorScan Drive::simulate(std::size_t scan) const {
  const Instant now = instant(scan);
  const Pose city_from_here = city_from_sensor(scan);
  SensorScan out;
  out.ecef_from_sensor = ecef_from_sensor(scan);
  out.utime = utime(scan);
  std::size_t beam = 0;
  for (const Direction azimuth : azimuths_) {
    for (const Direction elevation : elevations_) {
      const Eigen::Vector3d ahead(elevation.cosine * azimuth.cosine,
                                  elevation.cosine * azimuth.sine, elevation.sine);
      const auto sight =
          now.look(Beam(city_from_here.translation(), city_from_here.rotation() * ahead),
                   options_.max_range);
      ++beam;
      if (sight.t == kNoHit) continue;
      const double range =
          options_.sigma > 0 ? sight.t + options_.sigma * noise(scan, beam) : sight.t;
      out.points_sensor.push_back((range * ahead).cast<float>());
      out.intensities.push_back(reflectance(sight.material));
      out.colours.push_back(sight.colour);
    }
  }
  return out;
}

}  // namespace voxatlas
