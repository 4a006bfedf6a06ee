#pragma once

#include <string>

#include "base/result.hpp"
#include "cli/scan_input.hpp"

namespace voxatlas {

struct LogInput {
  std::string path;
  std::string origin;         ///< Of the poses' local frame; empty: it is ECEF. As KittiInput's.
  std::string cloud_channel;  ///< Take bot_core.pointcloud_t of this channel alone; empty: of all.
  std::string pose_channel;   ///< Take bot_core.pose_t of this one; empty: the only one there is.
};

/// The scans of a log that lcm-logger wrote: voxatlas.scan_t, whole or in parts, and
/// bot_core.pointcloud_t in the frame of the body whose bot_core.pose_t the log holds too. Types
/// are known by their fingerprints, whatever the channel. Scans come in the order they were heard,
/// a scan in parts where its last part was.
///
/// Damage:  what is not whole (an event, a scan that lacks parts) or contradicts itself, and a
///          cloud without a pose at its time, is left out, and told in `ending`.
/// Cost:    reads the log once before the first scan; then 50 bytes a part and 104 a pose.
/// Errors:  what LcmLog::open says; kNotFound where the log holds no scan; kInvalid where poses
///          came on several channels and none was chosen, or clouds without any pose.
Result<ScanInput> open_log(const LogInput& input);

}  // namespace voxatlas
