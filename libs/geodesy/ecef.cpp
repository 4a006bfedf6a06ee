#include "geodesy/ecef.hpp"

#include <fmt/format.h>

#include <GeographicLib/Geocentric.hpp>
#include <cmath>
#include <vector>

#include "base/check.hpp"

namespace voxatlas {
namespace {

Status check_within(const char* name, double value, double limit, const char* unit) {
  if (std::abs(value) <= limit) return {};  // Not so for NaN.
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{} = {} is not within +-{} {}", name, value, limit, unit));
}

Status check_finite(const char* name, double value) {
  if (std::isfinite(value)) return {};
  return fail(ErrorCode::kOutOfRange, fmt::format("{} = {} m is not finite", name, value));
}

}  // namespace

Result<Eigen::Vector3d> to_ecef(const Geodetic& place) {
  if (auto ok = check_within("latitude", place.latitude_deg, 90, "degrees"); !ok) {
    return pass_on(ok);
  }
  if (auto ok = check_within("longitude", place.longitude_deg, 360, "degrees"); !ok) {
    return pass_on(ok);
  }
  if (auto ok = check_finite("height", place.height); !ok) return pass_on(ok);
  Eigen::Vector3d p_ecef;
  GeographicLib::Geocentric::WGS84().Forward(place.latitude_deg, place.longitude_deg, place.height,
                                             p_ecef.x(), p_ecef.y(), p_ecef.z());
  return p_ecef;
}

Result<Geodetic> to_geodetic(const Eigen::Vector3d& p_ecef) {
  constexpr const char* kNames[] = {"ECEF x", "ECEF y", "ECEF z"};
  for (int axis = 0; axis < 3; ++axis) {
    if (auto ok = check_finite(kNames[axis], p_ecef[axis]); !ok) return pass_on(ok);
  }
  Geodetic place;
  GeographicLib::Geocentric::WGS84().Reverse(p_ecef.x(), p_ecef.y(), p_ecef.z(), place.latitude_deg,
                                             place.longitude_deg, place.height);
  return place;
}

Eigen::Vector3d up_at(const Eigen::Vector3d& p_ecef) {
  VOX_CHECK(p_ecef.allFinite());
  std::vector<double> axes(9);  // Row by row; columns east, north, up.
  Geodetic unused;
  GeographicLib::Geocentric::WGS84().Reverse(p_ecef.x(), p_ecef.y(), p_ecef.z(),
                                             unused.latitude_deg, unused.longitude_deg,
                                             unused.height, axes);
  return {axes[2], axes[5], axes[8]};
}

}  // namespace voxatlas
