#include "geodesy/enu_frame.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <utility>
#include <vector>

namespace voxatlas {
namespace {

/// The library's 9 numbers, row by row: columns east, north and up in ECEF.
Result<Pose> pose_of(const std::vector<double>& axes, const Eigen::Vector3d& origin_ecef) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(axes.data());
  return Pose::create(rotation, origin_ecef);
}

}  // namespace

Result<EnuFrame> EnuFrame::at(const Geodetic& origin) {
  auto origin_ecef = voxatlas::to_ecef(origin);
  if (!origin_ecef) return pass_on(origin_ecef, "origin of the local frame");
  std::vector<double> axes(9);
  double x = 0;
  double y = 0;
  double z = 0;
  GeographicLib::Geocentric::WGS84().Forward(origin.latitude_deg, origin.longitude_deg,
                                             origin.height, x, y, z, axes);
  auto pose = pose_of(axes, *origin_ecef);
  if (!pose) return pass_on(pose, "origin of the local frame");
  return EnuFrame(*pose);
}

Result<EnuFrame> EnuFrame::at(const Eigen::Vector3d& origin_ecef) {
  // Held against the cube first: the library turns NaN into a place like any other.
  auto place = Pose::create(Eigen::Matrix3d::Identity(), origin_ecef);
  if (!place) return pass_on(place, "origin of the local frame");
  std::vector<double> axes(9);
  Geodetic unused;
  GeographicLib::Geocentric::WGS84().Reverse(origin_ecef.x(), origin_ecef.y(), origin_ecef.z(),
                                             unused.latitude_deg, unused.longitude_deg,
                                             unused.height, axes);
  auto pose = pose_of(axes, origin_ecef);
  if (!pose) return pass_on(pose, "origin of the local frame");
  return EnuFrame(*pose);
}

}  // namespace voxatlas
