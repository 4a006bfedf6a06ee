#include "geodesy/pose_track.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

using TimedPose = std::pair<std::int64_t, Pose>;

Pose turned(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& place) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(angle, axis.normalized()));
  return Pose::from_quaternion(rotation, place).value();
}

TEST_CASE("a track gives what was put in, bit for bit, in any order", "[geodesy]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> any(-3, 3);
  std::vector<TimedPose> poses;
  for (std::int64_t i = 0; i < 500; ++i) {
    const Eigen::Vector3d axis(any(rng), any(rng), any(rng)), place(any(rng), any(rng), any(rng));
    poses.emplace_back(i * 10'000, turned(any(rng), axis, place));
  }
  auto shuffled = poses;
  std::ranges::shuffle(shuffled, rng);

  const PoseTrack track(shuffled);

  for (const auto& [utime, pose] : poses) REQUIRE(track.at(utime).value() == pose);
}

TEST_CASE("between two poses a track goes straight, and turns evenly", "[geodesy][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 1'000; ++round) {
    // Oracle: the angle about one axis, which grows with time; at most half a turn.
    const Eigen::Vector3d axis(any(rng), any(rng), any(rng));
    const Eigen::Vector3d from(any(rng), any(rng), any(rng)), step(any(rng), any(rng), any(rng));
    const double start = 3 * any(rng), turn = 3 * any(rng);
    const PoseTrack track({{-200'000, turned(start, axis, from)},
                           {300'000, turned(start + turn, axis, from + step)}});
    const double part = 0.5 * (1 + any(rng));
    const auto utime = std::llround(-200'000 + 500'000 * part);
    const double exact = static_cast<double>(utime + 200'000) / 500'000;

    const Pose got = track.at(utime).value();

    const Pose expected = turned(start + exact * turn, axis, from + exact * step);
    REQUIRE((got.translation() - expected.translation()).norm() < 1e-12);
    REQUIRE((got.rotation() - expected.rotation()).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a track turns the shorter way round", "[geodesy]") {
  const Eigen::Vector3d up(0, 0, 1), here(0, 0, 0);
  const double degree = std::numbers::pi / 180;
  const PoseTrack track({{0, turned(-10 * degree, up, here)},
                         {100, turned(350 * degree, up, here)},
                         {200, turned(370 * degree, up, here)}});
  const Eigen::Vector3d ahead = track.at(150).value() * Eigen::Vector3d(1, 0, 0);
  REQUIRE((ahead - Eigen::Vector3d(1, 0, 0)).norm() < 1e-12);  // 350 to 370: through 360.
  const Eigen::Vector3d before = track.at(50).value() * Eigen::Vector3d(1, 0, 0);
  REQUIRE((before - Eigen::Vector3d(std::cos(10 * degree), -std::sin(10 * degree), 0)).norm() <
          1e-12);  // The same pose twice: it stood still.
}

TEST_CASE("of two poses of one moment the first counts", "[geodesy]") {
  const Pose first = turned(0, {0, 0, 1}, {1, 0, 0}), second = turned(0, {0, 0, 1}, {2, 0, 0});
  REQUIRE(PoseTrack({{5, first}, {5, second}}).at(5).value() == first);
}

TEST_CASE("a track does not guess", "[geodesy]") {
  const Pose pose;
  REQUIRE(PoseTrack({}).empty());
  REQUIRE(PoseTrack({}).at(0).error().code == ErrorCode::kOutOfRange);
  const auto gap = PoseTrack::kLongestGap;
  const PoseTrack track({{0, pose}, {gap, pose}, {2 * gap + 1, pose}});
  REQUIRE_FALSE(track.empty());
  REQUIRE(track.at(gap / 2).has_value());
  REQUIRE(track.at(2 * gap + 1).has_value());
  for (const std::int64_t nowhere :
       {std::int64_t{-1}, gap + 1, 2 * gap, 2 * gap + 2, INT64_MIN, INT64_MAX}) {
    REQUIRE(track.at(nowhere).error().code == ErrorCode::kOutOfRange);
  }
  const PoseTrack wide({{INT64_MIN, pose}, {INT64_MAX, pose}});
  REQUIRE(wide.at(0).error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
