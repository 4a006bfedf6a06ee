#pragma once

#include <cstdint>

namespace voxatlas {

/// Microseconds since 1970-01-01 UTC: what messages and files carry. May jump with the clock.
std::int64_t utime_now();

/// Microseconds of a clock that never goes back: for deadlines and durations within a process.
std::int64_t steady_utime();

}  // namespace voxatlas
