#pragma once

#include <Eigen/Core>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "geodesy/pose.hpp"

namespace voxatlas {

/// A flat frame that touches the Earth at its origin: x east, y north, z up.
///
/// Frame:   ENU <-> ECEF (WGS 84), metres. Flat: 10 km from the origin the sea lies 8 m below it.
/// Borders: at the poles, where every way is south, the longitude of the origin says what east is;
///          an origin given in ECEF on the Earth's axis counts as longitude 0.
/// Errors:  the factories return kOutOfRange for an origin that is not finite, not on the Earth,
///          or off the index cube.
class EnuFrame {
 public:
  [[nodiscard]] static Result<EnuFrame> at(const Geodetic& origin);
  [[nodiscard]] static Result<EnuFrame> at(const Eigen::Vector3d& origin_ecef);

  const Pose& ecef_from_enu() const { return ecef_from_enu_; }
  const Eigen::Vector3d& origin_ecef() const { return ecef_from_enu_.translation(); }

  Eigen::Vector3d east_ecef() const { return ecef_from_enu_.rotation().col(0); }
  Eigen::Vector3d north_ecef() const { return ecef_from_enu_.rotation().col(1); }
  Eigen::Vector3d up_ecef() const { return ecef_from_enu_.rotation().col(2); }

  Eigen::Vector3d to_ecef(const Eigen::Vector3d& p_enu) const { return ecef_from_enu_ * p_enu; }
  Eigen::Vector3d to_enu(const Eigen::Vector3d& p_ecef) const {
    return ecef_from_enu_.rotation().transpose() * (p_ecef - origin_ecef());
  }

 private:
  explicit EnuFrame(const Pose& ecef_from_enu) : ecef_from_enu_(ecef_from_enu) {}

  Pose ecef_from_enu_;
};

}  // namespace voxatlas
