#pragma once

#include <Eigen/Core>

#include "base/result.hpp"

namespace voxatlas {

/// Half of the index cube's edge, metres: a point of the model has every |coordinate| below it.
inline constexpr double kCubeHalf = 6.4e6;

/// A place by latitude, longitude and height above the ellipsoid (not above the sea).
///
/// Frame:  WGS 84.
/// Units:  degrees, degrees, metres. North and east are positive.
struct Geodetic {
  double latitude_deg = 0;
  double longitude_deg = 0;
  double height = 0;
};

/// Errors: kOutOfRange for what is not finite, |latitude| above 90, |longitude| above 360.
[[nodiscard]] Result<Eigen::Vector3d> to_ecef(const Geodetic& place);

/// The longitude is within [-180, 180]; on the Earth's axis, where any would do, it is 0.
/// Errors: kOutOfRange for what is not finite.
[[nodiscard]] Result<Geodetic> to_geodetic(const Eigen::Vector3d& p_ecef);

/// Away from the Earth: the normal of the ellipsoid through the point, of length 1. Cells lie
/// parallel to ECEF's axes, so nothing else in voxatlas knows where up is. `p_ecef` is finite.
[[nodiscard]] Eigen::Vector3d up_at(const Eigen::Vector3d& p_ecef);

}  // namespace voxatlas
