#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geodesy/pose.hpp"
#include "integrate/scan.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

/// A scan as the sensor saw it and as files keep it: points around the sensor, and where it stood.
///
/// Frame: the sensor's (x forward, y left, z up). Units: metres; float, as files have it.
///        A point with a NaN or infinite coordinate is "no return" and is kept.
struct SensorScan {
  std::vector<Eigen::Vector3f> points_sensor;
  std::vector<float> intensities;  ///< Empty, or one a point; 0 to 1.
  std::vector<Rgb> colours;        ///< Empty, or one a point.
  Pose ecef_from_sensor;
  std::int64_t utime = 0;
};

/// The rays of `seen` in ECEF, as the integrator takes them; `sigma` and `min_range` as in Scan.
inline Scan to_scan(const SensorScan& seen, double sigma, double min_range) {
  Scan scan;
  scan.origin_ecef = seen.ecef_from_sensor.translation();
  scan.endpoints_ecef.reserve(seen.points_sensor.size());
  for (const Eigen::Vector3f& p_sensor : seen.points_sensor) {
    scan.endpoints_ecef.push_back(seen.ecef_from_sensor * p_sensor.cast<double>());
  }
  scan.colours = seen.colours;
  scan.sigma = sigma;
  scan.min_range = min_range;
  scan.utime = seen.utime;
  return scan;
}

}  // namespace voxatlas
