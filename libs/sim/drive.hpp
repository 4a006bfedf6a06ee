#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "geodesy/pose.hpp"
#include "integrate/sensor_scan.hpp"
#include "sim/city.hpp"
#include "sim/route.hpp"

namespace voxatlas {

struct DriveOptions {
  std::size_t scans = 200;
  std::uint64_t seed = 1;         ///< Of the way and the noise.
  double azimuth_step_deg = 0.4;  ///< 900 x 64 = 57 600 beams a scan; 54 000 return.
  double sigma = 0.02;            ///< Standard deviation of a range, metres; 0: exact.
  double max_range = 120;         ///< Metres; what is farther does not return.
  double speed = 8;               ///< Metres a second.
  std::int64_t start_utime = 1'433'152'800'000'000;  ///< 2015-06-01 10:00 UTC.
};

/// A car that drives through the city with two scanners on its roof.
///
/// Source:  the paper's section 6: two HDL-64E, 64 beams from -24.8 to +2 degrees, 10 turns a
///          second, tilted by 25 degrees: here each looks up on its own side of the car, over the
///          facades, and down on the other, over the road.
/// Scans:   scan i is one turn of scanner i % 2; the scanners turn half a period apart, so scans
///          come at 20 Hz. A turn is taken at one instant: the car stands still in it.
/// Noise:   gaussian on the range; drawn by seed, scan and beam, so that scan i can be made alone,
///          in any order and by any thread, and is always the same.
/// Others:  a vehicle that would run into the scanning car is left out for as long. The scanning
///          car itself is not seen.
/// Cost:    see README.md. Ownership: borrows the city. Threads: safe to share.
class Drive {
 public:
  /// Errors: kOutOfRange for options that no scanner could have.
  [[nodiscard]] static Result<Drive> create(const City& city, const DriveOptions& options);

  std::size_t scan_count() const { return options_.scans; }
  std::size_t beams_per_scan() const { return azimuths_.size() * elevations_.size(); }

  double seconds(std::size_t scan) const { return 0.05 * static_cast<double>(scan); }
  std::int64_t utime(std::size_t scan) const;
  Pose city_from_sensor(std::size_t scan) const;
  Pose ecef_from_sensor(std::size_t scan) const;

  /// The city as scan `scan` meets it.
  Instant instant(std::size_t scan) const;

  /// A beam that did not return gives no point.
  SensorScan simulate(std::size_t scan) const;

 private:
  struct Direction {
    double cosine, sine;
  };

  Drive(const City& city, const DriveOptions& options);
  Pose city_from_car(std::size_t scan) const;
  double noise(std::size_t scan, std::size_t beam) const;

  const City& city_;
  DriveOptions options_;
  Route route_;
  std::vector<Direction> azimuths_, elevations_;
};

}  // namespace voxatlas
