#include "geodesy/pose.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "geodesy/ecef.hpp"

namespace voxatlas {
namespace {

constexpr double kTolerance = 1e-4;  // Of what is handed in; pose files carry 5 to 10 digits.
constexpr double kTrue = 1e-14;      // Of what is kept.

double deviation(const Eigen::Matrix3d& r) {
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

Status check_place(const Eigen::Vector3d& p) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(p[axis]) < kCubeHalf)) {  // NaN too.
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("pose: position {} = {} m is not within +-{} m, the index cube",
                              "xyz"[axis], p[axis], kCubeHalf));
    }
  }
  return {};
}

Status check_rotation(const Eigen::Matrix3d& r) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (!(std::abs(r(row, column)) <= 1 + kTolerance)) {
        const auto code =
            std::isfinite(r(row, column)) ? ErrorCode::kInvalid : ErrorCode::kOutOfRange;
        return fail(code, fmt::format("pose: rotation row {} column {} = {} is not within +-1", row,
                                      column, r(row, column)));
      }
    }
  }
  if (const double off = deviation(r); off > kTolerance) {
    return fail(ErrorCode::kInvalid,
                fmt::format("pose: rotation's columns are orthonormal only to {:.3g}, beyond {}",
                            off, kTolerance));
  }
  if (const double determinant = r.determinant(); determinant < 0) {
    return fail(ErrorCode::kInvalid,
                fmt::format("pose: rotation is a mirror, its determinant is {:.6g}", determinant));
  }
  return {};
}

/// The rotation with the least sum of squared differences: U V^T of the singular values' U S V^T.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& r) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace

Result<Pose> Pose::create(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  if (auto ok = check_rotation(rotation); !ok) return pass_on(ok);
  if (auto ok = check_place(translation); !ok) return pass_on(ok);
  return Pose(deviation(rotation) <= kTrue ? rotation : nearest_rotation(rotation), translation);
}

Result<Pose> Pose::from_rows(std::span<const double, 12> rows) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(rows.data());
  return create(matrix.leftCols<3>(), matrix.rightCols<1>());
}

Result<Pose> Pose::from_quaternion(const Eigen::Quaterniond& rotation,
                                   const Eigen::Vector3d& translation) {
  if (const double length = rotation.norm(); !(std::abs(length - 1) <= kTolerance)) {
    return fail(std::isfinite(length) ? ErrorCode::kInvalid : ErrorCode::kOutOfRange,
                fmt::format("pose: quaternion's length is {}, not 1", length));
  }
  return create(rotation.normalized().toRotationMatrix(), translation);
}

std::array<double, 12> Pose::rows() const {
  std::array<double, 12> rows{};
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(rows.data());
  matrix << rotation_, translation_;
  return rows;
}

Eigen::Isometry3d Pose::isometry() const {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = rotation_;
  result.translation() = translation_;
  return result;
}

Result<Pose> operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return Pose::create(a_from_b.rotation() * b_from_c.rotation(), a_from_b * b_from_c.translation());
}

}  // namespace voxatlas
