#pragma once

#include <functional>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

/// Lets glibc's malloc keep up to 64 MiB that were freed: messages of megabytes come and go, and
/// taking their pages back and clearing them anew each time was a fifth of what receiving them
/// costs. Of no effect where another allocator is linked.
void keep_freed_memory();

/// Which services go first where all processors are busy, as niceness: the hub and pictures, for
/// which somebody waits; then the store, whose commits take more scans at once when they come
/// later; then ingest, so that an import at full speed takes what is left; compressing has time.
///
/// Niceness counts within a session or a control group: scripts/up, the units of systemd and
/// compose.yaml see to the rest.
enum class Precedence { kFirst = 0, kStore = 4, kIngest = 7, kCompress = 19 };

/// What every service's main does once its options are read: names its log lines, takes its place
/// among the services, lets SIGINT and SIGTERM ask it to stop, serves, and says how it ended.
/// Returns the process's exit code: 0 where it was asked to stop, 1 where `serve` came back with an
/// error or nothing could go on (an exception: no memory).
int run_service(const std::string& log_name, Precedence precedence,
                const std::function<Status()>& serve);

}  // namespace voxatlas
