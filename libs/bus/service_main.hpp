#pragma once

#include <functional>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

/// Lets glibc's malloc keep up to 64 MiB that were freed: messages of megabytes come and go, and
/// taking their pages back and clearing them anew each time was a fifth of what receiving them
/// costs. Of no effect where another allocator is linked.
void keep_freed_memory();

/// What every service's main does once its options are read: names its log lines, lets SIGINT and
/// SIGTERM ask it to stop, serves, and says how it ended. Returns the process's exit code: 0 where
/// it was asked to stop, 1 where `serve` came back with an error or nothing could go on (an
/// exception: no memory).
int run_service(const std::string& log_name, const std::function<Status()>& serve);

}  // namespace voxatlas
