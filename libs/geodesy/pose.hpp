#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>

#include "base/result.hpp"

namespace voxatlas {

/// Where a sensor stands and which way it looks: a rotation and a place, `ecef_from_sensor`.
/// The same type places a sensor in a local frame, and a local frame on the Earth.
///
/// Frame:   `a_from_b * p_b` is `p_a`; a pose itself does not know its frames, its name does.
/// Units:   metres; the rotation is orthonormal to 1e-14, right-handed.
/// Errors:  the factories return kOutOfRange for what is not finite and for a place with a
///          |coordinate| of 6.4e6 m or more (off the index cube), kInvalid for what is no rotation:
///          columns that are orthonormal only beyond 1e-4, and mirrors.
/// Cost:    96 bytes.
class Pose {
 public:
  Pose() = default;  ///< No rotation, at the frame's origin.

  /// A rotation written with few digits is replaced by the nearest true one; one that is already
  /// true to 1e-14 stays as it is, bit for bit, so that a pose survives the way over the bus.
  [[nodiscard]] static Result<Pose> create(const Eigen::Matrix3d& rotation,
                                           const Eigen::Vector3d& translation);
  /// From the 12 numbers of a pose file's line: a 3x4 matrix [rotation | translation], row by row.
  [[nodiscard]] static Result<Pose> from_rows(std::span<const double, 12> rows);
  /// A quaternion whose length is 1 to 1e-4.
  [[nodiscard]] static Result<Pose> from_quaternion(const Eigen::Quaterniond& rotation,
                                                    const Eigen::Vector3d& translation);

  const Eigen::Matrix3d& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }
  std::array<double, 12> rows() const;
  Eigen::Isometry3d isometry() const;

  /// p_a of p_b. Written out, so that the order of the additions, and with it the last bit, does
  /// not depend on how a compiler or a processor likes to sum.
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    return {row_times(0, p) + translation_.x(), row_times(1, p) + translation_.y(),
            row_times(2, p) + translation_.z()};
  }

  friend bool operator==(const Pose& a, const Pose& b) {
    return a.rotation_ == b.rotation_ && a.translation_ == b.translation_;
  }

 private:
  Pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation), translation_(translation) {}

  double row_times(int row, const Eigen::Vector3d& p) const {
    return rotation_(row, 0) * p.x() + rotation_(row, 1) * p.y() + rotation_(row, 2) * p.z();
  }

  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

/// `ecef_from_local * local_from_sensor` is `ecef_from_sensor`.
/// Errors: kOutOfRange where that place is off the cube.
[[nodiscard]] Result<Pose> operator*(const Pose& a_from_b, const Pose& b_from_c);

}  // namespace voxatlas
