#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace voxatlas {

/// Processor time of the whole machine since it started, in ticks. What runs at a lowered priority,
/// as compressors do, counts as idle.
struct ProcessorTicks {
  std::uint64_t busy = 0, all = 0;
};

/// From the text of /proc/stat; nullopt where that does not begin as proc(5) says.
std::optional<ProcessorTicks> parse_processor_ticks(std::string_view proc_stat);

/// How busy the machine is with what comes before compressing.
///
/// Units: 0..1, of all processors, over the last half second. 0 where the system does not tell.
/// Threads: one at a time.
class MachineLoad {
 public:
  double now(std::int64_t steady_us);

 private:
  std::optional<ProcessorTicks> before_;
  std::int64_t looked_ = 0;
  double load_ = 0;
};

}  // namespace voxatlas
