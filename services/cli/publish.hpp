#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "cli/log_input.hpp"
#include "cli/scan_input.hpp"

namespace voxatlas {

struct PublishOptions {
  std::string url;
  KittiInput kitti;                     ///< A folder, or, where that names a log of lcm-logger,
  LogInput log;                         ///< the rest of what is said of it, or
  SimulatedInput simulate;              ///< a simulated drive, where it has scans.
  std::string source;                   ///< Empty: the input's name.
  std::optional<std::int64_t> session;  ///< Unset: the input's identity, so that it resumes.
  std::optional<double> sigma, min_range;
  std::int32_t ingests = 1;
  std::optional<double> hz;  ///< At most so many scans a second.
  bool json = false;
};

/// Publishes every scan reliably and returns when each is durable. Run again after it was
/// interrupted, or killed, it goes on with the first scan that is not; run again after its end, it
/// does nothing. Errors: the input's, at its end if the rest was whole; kUnavailable where nobody
/// takes the scans.
Status run_publish(const PublishOptions& options);

}  // namespace voxatlas
