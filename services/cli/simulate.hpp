#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct SimulateOptions {
  std::size_t scans = 0;
  std::uint64_t seed = 1;
  std::string out;  ///< Folder to be made.
};

/// Writes the simulated drive as a folder that `publish` reads (KITTI odometry form, with colours).
/// Errors: those of the folder.
Status run_simulate(const SimulateOptions& options);

}  // namespace voxatlas
