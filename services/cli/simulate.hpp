#pragma once

#include <string>

#include "base/result.hpp"
#include "cli/scan_input.hpp"

namespace voxatlas {

struct SimulateOptions {
  SimulatedInput drive;
  std::string out;  ///< Folder to be made.
};

/// Writes the simulated drive as a folder that `publish` reads (KITTI odometry form, with colours).
/// Errors: those of the folder.
Status run_simulate(const SimulateOptions& options);

}  // namespace voxatlas
