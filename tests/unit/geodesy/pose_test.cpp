#include "geodesy/pose.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "geodesy/enu_frame.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

Eigen::Quaterniond any_rotation(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng)).normalized();
}

Eigen::Vector3d any_vector(std::mt19937_64& rng, double limit) {
  std::uniform_real_distribution<double> metres(-limit, limit);
  return {metres(rng), metres(rng), metres(rng)};
}

double deviation(const Eigen::Matrix3d& r) {
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

std::array<double, 12> standing() { return {1, 0, 0, 100, 0, 1, 0, 200, 0, 0, 1, 300}; }

TEST_CASE("a Pose moves points as its matrix does", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 5'000; ++i) {
    const auto q = any_rotation(rng);
    const auto t = any_vector(rng, 6.3e6);
    const auto pose = Pose::from_quaternion(q, t);
    REQUIRE(pose.has_value());
    const auto p = any_vector(rng, 200);
    // Oracle: the quaternion's own formula, and the 12 numbers one by one.
    const Eigen::Vector3d turned = q._transformVector(p) + t;
    REQUIRE((*pose * p - turned).norm() < 1e-8);
    const auto rows = pose->rows();
    for (std::size_t row = 0; row < 3; ++row) {
      const double sum = rows[4 * row] * p.x() + rows[4 * row + 1] * p.y() +
                         rows[4 * row + 2] * p.z() + rows[4 * row + 3];
      REQUIRE((*pose * p)[static_cast<int>(row)] == sum);
    }
    REQUIRE((pose->isometry() * p - turned).norm() < 1e-8);
  }
}

TEST_CASE("a Pose written with few digits becomes the nearest rotation", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> noise(-1.5e-5, 1.5e-5);
  for (int i = 0; i < 2'000; ++i) {
    const Eigen::Matrix3d exact = any_rotation(rng).toRotationMatrix();
    Eigen::Matrix3d written = exact;
    for (int k = 0; k < 9; ++k) written.data()[k] += noise(rng);
    const auto pose = Pose::create(written, {1, 2, 3});
    REQUIRE(pose.has_value());
    REQUIRE(deviation(pose->rotation()) < 1e-14);
    REQUIRE(pose->rotation().determinant() > 0);
    const double distance = (pose->rotation() - written).norm();
    REQUIRE(distance <= (exact - written).norm());
    // Oracle for nearest: turned a little about any axis, it lies further off.
    for (int k = 0; k < 4; ++k) {
      const Eigen::AngleAxisd little(1e-5, any_vector(rng, 1).normalized());
      REQUIRE((little.toRotationMatrix() * pose->rotation() - written).norm() > distance);
    }
  }
}

TEST_CASE("a Pose is true to 1e-14 however many digits it was written with", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 3'000; ++i) {
    const int digits = 5 + i % 12;
    const double unit = std::pow(10.0, digits);
    const Eigen::Matrix3d exact = any_rotation(rng).toRotationMatrix();
    const Eigen::Matrix3d written = (exact * unit).array().round().matrix() / unit;
    const auto pose = Pose::create(written, {1, 2, 3});
    CAPTURE(digits);
    REQUIRE(pose.has_value());
    REQUIRE(deviation(pose->rotation()) <= 1e-14);
    REQUIRE((pose->rotation() - exact).cwiseAbs().maxCoeff() < 2 / unit + 1e-14);
  }
}

TEST_CASE("a Pose survives being written out and read, bit for bit", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 5'000; ++i) {
    Eigen::Matrix3d written = any_rotation(rng).toRotationMatrix();
    if (i % 2 == 0) written = (written * 1e6).array().round().matrix() / 1e6;
    const auto pose = Pose::create(written, any_vector(rng, 6e6));
    REQUIRE(pose.has_value());
    REQUIRE(Pose::from_rows(pose->rows()) == *pose);
  }
}

TEST_CASE("from_rows reads row by row", "[geodesy]") {
  const auto pose = Pose::from_rows(std::array<double, 12>{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30});
  REQUIRE(pose.has_value());
  REQUIRE(*pose * Eigen::Vector3d(1, 0, 0) == Eigen::Vector3d(10, 21, 30));
  REQUIRE(pose->translation() == Eigen::Vector3d(10, 20, 30));
  REQUIRE(Pose() * Eigen::Vector3d(1, 2, 3) == Eigen::Vector3d(1, 2, 3));
}

TEST_CASE("a Pose refuses each number that is not finite, and names it", "[geodesy]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (std::size_t at = 0; at < 12; ++at) {
    for (const double bad : {nan, inf, -inf}) {
      auto rows = standing();
      rows[at] = bad;
      const auto refused = Pose::from_rows(rows);
      REQUIRE_FALSE(refused.has_value());
      REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
      const std::string place =
          at % 4 == 3 ? std::string("position ") + "xyz"[at / 4]
                      : "row " + std::to_string(at / 4) + " column " + std::to_string(at % 4);
      REQUIRE_THAT(refused.error().message, Catch::Contains(place + " = "));
    }
  }
}

TEST_CASE("a Pose refuses what is no rotation, and says why", "[geodesy]") {
  struct Row {
    std::array<double, 9> r;
    const char* named;
  };
  const Row rows[] = {
      {{1, 0, 0, 0, 1, 0, 0, 0, -1}, "mirror"},
      {{0, 1, 0, 1, 0, 0, 0, 0, 1}, "mirror"},
      {{1, 0, 0, 0, 1, 0, 0, 0, 0.9999}, "orthonormal only to 0.0002"},
      {{1, 0, 0, 0.0002, 1, 0, 0, 0, 1}, "orthonormal only to 0.0002"},
      {{0, 0, 0, 0, 0, 0, 0, 0, 0}, "orthonormal only to 1"},
      {{2, 0, 0, 0, 2, 0, 0, 0, 2}, "row 0 column 0 = 2"},
      {{1, 0, 0, 0, 1, 0, 0, -1e300, 1}, "row 2 column 1 = -1e+300"},
  };
  for (const auto& row : rows) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> r(row.r.data());
    const auto refused = Pose::create(r, {0, 0, 0});
    REQUIRE_FALSE(refused.has_value());
    REQUIRE(refused.error().code == ErrorCode::kInvalid);
    REQUIRE_THAT(refused.error().message, Catch::Contains(row.named));
  }
  const auto half = Pose::from_quaternion(Eigen::Quaterniond(0.5, 0, 0, 0), {0, 0, 0});
  REQUIRE_FALSE(half.has_value());
  REQUIRE(half.error().code == ErrorCode::kInvalid);
  REQUIRE_THAT(half.error().message, Catch::Contains("0.5"));
}

TEST_CASE("a Pose accepts a rotation that is orthonormal to 1e-4", "[geodesy]") {
  const auto pose =
      Pose::from_rows(std::array<double, 12>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.99996, 0});
  REQUIRE(pose.has_value());
  REQUIRE(deviation(pose->rotation()) < 1e-14);
}

TEST_CASE("a Pose refuses a place off the Earth's cube, and names it", "[geodesy]") {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double bad : {6.4e6, -6.4e6, 1e12}) {
      auto rows = standing();
      rows[4 * axis + 3] = std::nextafter(bad, 0);
      REQUIRE(Pose::from_rows(rows).has_value() == (bad < 1e12));
      rows[4 * axis + 3] = bad;
      const auto refused = Pose::from_rows(rows);
      REQUIRE_FALSE(refused.has_value());
      REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
      REQUIRE_THAT(refused.error().message,
                   Catch::Contains(std::string("position ") + "xyz"[axis] + " = "));
    }
  }
}

TEST_CASE("composed Poses move points as one after the other", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 2'000; ++i) {
    const auto frame = EnuFrame::at(Geodetic{49.01, 8.43, 110});
    const auto local_from_sensor = Pose::from_quaternion(any_rotation(rng), any_vector(rng, 1000));
    const auto ecef_from_sensor = frame->ecef_from_enu() * *local_from_sensor;
    REQUIRE(ecef_from_sensor.has_value());
    const auto p = any_vector(rng, 100);
    REQUIRE((*ecef_from_sensor * p - frame->to_ecef(*local_from_sensor * p)).norm() < 1e-8);
    REQUIRE(deviation(ecef_from_sensor->rotation()) < 1e-14);
  }
  const auto far = Pose::create(Eigen::Matrix3d::Identity(), {6e6, 0, 0});
  const auto off = *far * *far;
  REQUIRE_FALSE(off.has_value());
  REQUIRE(off.error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
