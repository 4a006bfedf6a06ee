#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "geodesy/pose.hpp"

namespace voxatlas {

/// Where something was, over time: poses at some moments, and what lies between two of them.
///
/// Between: the place on the straight line, the rotation by slerp, the shorter way round.
/// Borders: a moment that has a pose gets that pose, bit for bit. Of two poses of one moment the
///          first counts.
/// Errors:  at: kOutOfRange before the first, after the last, and between two that lie further
///          apart than kLongestGap: nobody knows where it was.
/// Units:   microseconds. Cost: 104 bytes a pose; at() is a binary search.
/// Threads: const calls from any number.
class PoseTrack {
 public:
  static constexpr std::int64_t kLongestGap = 1'000'000;

  /// In any order.
  explicit PoseTrack(std::vector<std::pair<std::int64_t, Pose>> poses);

  [[nodiscard]] Result<Pose> at(std::int64_t utime) const;
  bool empty() const { return poses_.empty(); }

 private:
  std::vector<std::pair<std::int64_t, Pose>> poses_;  // Ascending by time, one a moment.
};

}  // namespace voxatlas
