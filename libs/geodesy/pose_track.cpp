#include "geodesy/pose_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace voxatlas {

using TimedPose = std::pair<std::int64_t, Pose>;

PoseTrack::PoseTrack(std::vector<TimedPose> poses) : poses_(std::move(poses)) {
  std::ranges::stable_sort(poses_, {}, &TimedPose::first);
  const auto same_time = [](const auto& a, const auto& b) { return a.first == b.first; };
  poses_.erase(std::unique(poses_.begin(), poses_.end(), same_time), poses_.end());
}

Result<Pose> PoseTrack::at(std::int64_t utime) const {
  const auto after = std::ranges::lower_bound(poses_, utime, {}, &TimedPose::first);
  if (after != poses_.end() && after->first == utime) return after->second;
  if (after == poses_.begin() || after == poses_.end()) {
    const auto known = poses_.empty() ? std::string("there are none")
                                      : fmt::format("they go from {} to {}", poses_.front().first,
                                                    poses_.back().first);
    return fail(ErrorCode::kOutOfRange, fmt::format("no pose at utime {}: {}", utime, known));
  }
  const auto before = std::prev(after);
  // Unsigned: a log may hold any two times, and their difference 64 bits.
  const auto gap =
      static_cast<std::uint64_t>(after->first) - static_cast<std::uint64_t>(before->first);
  if (gap > kLongestGap) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("no pose at utime {}: those around it lie {} ms apart, more than {}",
                            utime, gap / 1000, kLongestGap / 1000));
  }
  const double part = static_cast<double>(utime - before->first) / static_cast<double>(gap);
  const Eigen::Quaterniond from(before->second.rotation()), to(after->second.rotation());
  return Pose::from_quaternion(
      from.slerp(part, to), before->second.translation() + part * (after->second.translation() -
                                                                   before->second.translation()));
}

}  // namespace voxatlas
