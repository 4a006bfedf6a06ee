#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "octree/colour.hpp"

namespace voxatlas {

/// The rays of one sensor revolution or shot: one origin, many endpoints.
///
/// Frame: ECEF. Units: metres. An endpoint with a NaN or infinite coordinate is "no return":
/// dropped
///        and counted by the integrator.
struct Scan {
  Eigen::Vector3d origin_ecef = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> endpoints_ecef;
  std::vector<Rgb> colours;  ///< Empty, or one an endpoint.
  double sigma = 0;          ///< Standard deviation of the whole chain, localisation included.
  double min_range = 0;      ///< The sensor's own: nearer returns are dropped. 0: none.
  std::int64_t utime = 0;    ///< When the scan was taken.
};

}  // namespace voxatlas
