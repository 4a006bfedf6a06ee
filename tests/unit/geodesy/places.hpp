#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "geodesy/ecef.hpp"

namespace voxatlas::test {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kSemiMajor = 6'378'137.0;         // WGS 84's two defining numbers:
inline constexpr double kFlattening = 1 / 298.257223563;  // a and f.
inline constexpr double kSquaredEccentricity = kFlattening * (2 - kFlattening);

/// The ellipsoid's normal, by its definition.
inline Eigen::Vector3d up_by_angles(const Geodetic& place) {
  const double latitude = place.latitude_deg * kPi / 180;
  const double longitude = place.longitude_deg * kPi / 180;
  return {std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
          std::sin(latitude)};
}

/// Oracle: the closed form in every textbook, with the radius of curvature N.
inline Eigen::Vector3d ecef_by_closed_form(const Geodetic& place) {
  const Eigen::Vector3d up = up_by_angles(place);
  const double n = kSemiMajor / std::sqrt(1 - kSquaredEccentricity * up.z() * up.z());
  return {(n + place.height) * up.x(), (n + place.height) * up.y(),
          (n * (1 - kSquaredEccentricity) + place.height) * up.z()};
}

/// Anywhere: also the poles, the equator, the date line, deep down and high up.
inline Geodetic any_place(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Geodetic place{90 * unit(rng), 180 * unit(rng), 10'000 * unit(rng)};
  switch (rng() % 8) {
    case 0:
      place.latitude_deg = rng() % 2 == 0 ? 90 : -90;
      break;
    case 1:
      place.latitude_deg = 0;
      break;
    case 2:
      place.longitude_deg = rng() % 2 == 0 ? 180 : -180;
      break;
    case 3:
      place.longitude_deg = 90 * static_cast<double>(rng() % 4) - 180;
      break;
    case 4:
      place.latitude_deg = 90 - 1e-9 * unit(rng) * unit(rng) - 1e-9;
      break;
    default:
      break;
  }
  return place;
}

}  // namespace voxatlas::test
