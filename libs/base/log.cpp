#include "base/log.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "base/utime.hpp"

namespace voxatlas {

static std::string& log_name() {
  static std::string name = "voxatlas";
  return name;
}

void set_log_name(std::string name) { log_name() = std::move(name); }

void log_line(std::string_view level, std::string_view text) {
  const auto now = utime_now();
  auto line = fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z {} {}: {}",
                          fmt::gmtime(std::time_t{now / 1'000'000}), now / 1000 % 1000, log_name(),
                          level, text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);  // One call: lines of threads do not mix.
}

}  // namespace voxatlas
