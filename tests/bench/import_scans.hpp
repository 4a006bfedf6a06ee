#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "integrate/scan.hpp"

namespace voxatlas::bench {

/// The first `count` scans of a folder in KITTI odometry form, without points nearer than 2.5 m.
Result<std::vector<Scan>> real_scans(const std::string& folder, const std::string& poses,
                                     std::size_t count);

/// The first `count` scans of the simulated drive.
Result<std::vector<Scan>> simulated_scans(std::size_t count);

}  // namespace voxatlas::bench
