#pragma once

#include <functional>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

/// What every service's main does once its options are read: names its log lines, lets SIGINT and
/// SIGTERM ask it to stop, serves, and says how it ended. Returns the process's exit code: 0 where
/// it was asked to stop, 1 where `serve` came back with an error or nothing could go on (an
/// exception: no memory).
int run_service(const std::string& log_name, const std::function<Status()>& serve);

}  // namespace voxatlas
