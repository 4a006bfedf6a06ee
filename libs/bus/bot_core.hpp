#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "geodesy/pose.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

/// Messages of MIT's bot_core package, as logs hold them (lcmtypes/bot_core).

/// Which of the types that a log may hold scans in a message is, by its fingerprint.
enum class LoggedType { kOther, kScan, kPointCloud, kPose };
LoggedType logged_type(ByteView message);

/// bot_core.pointcloud_t. Frame: the body's. Units: metres; NaN: no return.
struct BotPointCloud {
  std::int64_t utime = 0;
  std::string frame_id;
  std::vector<Eigen::Vector3f> points;
  std::vector<Rgb> colours;             ///< One a point where there are channels r, g and b.
  std::optional<Error> colour_problem;  ///< Why there are none although the channels are.
};
/// Reads it without lcm-gen's decoder, which makes a vector of each point: 170 times slower.
/// Errors:  kCorrupt for bytes that are not exactly one message. Memory: bounded by the input's.
Result<BotPointCloud> decode_point_cloud(ByteView message);

/// bot_core.pose_t, as far as it is of use here.
struct BotPose {
  std::int64_t utime = 0;
  Pose local_from_body;
};
/// Errors: kCorrupt for other bytes; Pose's for a quaternion or a place that is none.
Result<BotPose> decode_bot_pose(ByteView message);

}  // namespace voxatlas
