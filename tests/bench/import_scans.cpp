#include "bench/import_scans.hpp"

#include "io/kitti.hpp"
#include "sim/city.hpp"
#include "sim/drive.hpp"

namespace voxatlas::bench {
namespace {

constexpr double kSigma = 0.02;
constexpr double kCar = 2.5;  ///< Nearer points are the scanning car.

/// What the integrator would drop is dropped here, so that both sides get the same rays.
Scan without_car(const SensorScan& seen) {
  SensorScan kept = seen;
  kept.points_sensor.clear();
  kept.colours.clear();
  for (const auto& p : seen.points_sensor) {
    if (p.norm() >= kCar) kept.points_sensor.push_back(p);
  }
  return to_scan(kept, kSigma, 0);
}

}  // namespace

Result<std::vector<Scan>> real_scans(const std::string& folder, const std::string& poses,
                                     std::size_t count) {
  auto kitti = KittiFolder::open(folder, {.poses = poses, .origin = {}});
  if (!kitti) return pass_on(kitti);
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < std::min(count, kitti->scan_count()); ++i) {
    auto read = kitti->read(i);
    if (!read) return pass_on(read);
    scans.push_back(without_car(read->scan));
  }
  return scans;
}

Result<std::vector<Scan>> simulated_scans(std::size_t count) {
  auto city = City::create({});
  if (!city) return pass_on(city);
  DriveOptions options;
  options.scans = count;
  auto drive = Drive::create(*city, options);
  if (!drive) return pass_on(drive);
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    scans.push_back(without_car(drive->simulate(i)));
  }
  return scans;
}

}  // namespace voxatlas::bench
