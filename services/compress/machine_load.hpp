#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace voxatlas {

/// Processor time of the whole machine since it started, in ticks. What runs at a lowered priority
/// is busy, too: the store and ingests do.
struct ProcessorTicks {
  std::uint64_t busy = 0, all = 0;
};

/// From the text of /proc/stat; nullopt where that does not begin as proc(5) says.
std::optional<ProcessorTicks> parse_processor_ticks(std::string_view proc_stat);

/// The share of all processors that was busy between two moments with anything but us, who took
/// `own` ticks; 0..1, 0 where the clocks say nothing.
double load_between(const ProcessorTicks& before, const ProcessorTicks& after, std::uint64_t own);

/// How busy the machine is with anything but this process.
///
/// Units: 0..1, of all processors, over the last half second. 0 where the system does not tell.
/// Threads: one at a time.
class MachineLoad {
 public:
  double now(std::int64_t steady_us);

 private:
  std::optional<ProcessorTicks> before_;
  std::uint64_t own_before_ = 0;
  std::int64_t looked_ = 0;
  double load_ = 0;
};

}  // namespace voxatlas
