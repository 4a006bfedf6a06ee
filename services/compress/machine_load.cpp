#include "compress/machine_load.hpp"

#include <sys/times.h>

#include <array>
#include <charconv>
#include <fstream>
#include <string>

namespace voxatlas {

std::optional<ProcessorTicks> parse_processor_ticks(std::string_view proc_stat) {
  constexpr std::string_view kBegin = "cpu ";
  if (!proc_stat.starts_with(kBegin)) return std::nullopt;
  // user nice system idle iowait irq softirq steal
  std::array<std::uint64_t, 8> ticks{};
  const char* at = proc_stat.data() + kBegin.size();
  const char* const end = proc_stat.data() + proc_stat.size();
  for (auto& value : ticks) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{}) return std::nullopt;
    at = next;
  }
  ProcessorTicks sum;
  for (const auto value : ticks) sum.all += value;
  sum.busy = sum.all - ticks[3] - ticks[4];
  return sum;
}

double load_between(const ProcessorTicks& before, const ProcessorTicks& after, std::uint64_t own) {
  if (after.all <= before.all || after.busy < before.busy + own) return 0;
  return static_cast<double>(after.busy - before.busy - own) /
         static_cast<double>(after.all - before.all);
}

/// Ticks that this process's threads took.
static std::uint64_t own_ticks() {
  tms own{};
  ::times(&own);
  return static_cast<std::uint64_t>(own.tms_utime + own.tms_stime);
}

double MachineLoad::now(std::int64_t steady_us) {
  constexpr std::int64_t kWindow = 500'000;
  if (before_ && steady_us - looked_ < kWindow) return load_;
  looked_ = steady_us;
  std::string line;
  std::ifstream stat("/proc/stat");
  std::getline(stat, line);
  const auto ticks = parse_processor_ticks(line);
  const std::uint64_t own = own_ticks();
  load_ = ticks && before_ ? load_between(*before_, *ticks, own - own_before_) : 0;
  own_before_ = own;
  before_ = ticks;
  return load_;
}

}  // namespace voxatlas
