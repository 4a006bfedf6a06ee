#include "base/log.hpp"

#include <fmt/chrono.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>

#include "base/utime.hpp"

namespace voxatlas {
namespace {

/// systemd names the device and the inode of the journal's socket: standard error may by now be
/// another file.
bool journal_reads() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat file {};
  return stream != nullptr && ::fstat(STDERR_FILENO, &file) == 0 &&
         fmt::format("{}:{}", file.st_dev, file.st_ino) == stream;
}

struct Log {
  std::string name = "voxatlas";
  LogForm form{.json = false, .journal = journal_reads()};
};

Log& log() {
  static Log the_log;
  return the_log;
}

/// syslog's numbers.
int priority(std::string_view level) { return level == "error" ? 3 : level == "warning" ? 4 : 6; }

std::string time_text(std::int64_t utime) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::time_t{utime / 1'000'000}),
                     utime / 1000 % 1000);
}

}  // namespace

void set_log_name(std::string name) { log().name = std::move(name); }

void log_as_json() { log().form.json = true; }

std::string log_text(LogForm form, std::int64_t utime, std::string_view name,
                     std::string_view level, std::string_view text) {
  std::string line;
  if (form.json) {
    const nlohmann::json event = {{"time", time_text(utime)},
                                  {"service", std::string(name)},
                                  {"level", std::string(level)},
                                  {"text", std::string(text)}};
    line = event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  } else {
    if (!form.journal) line = fmt::format("{} {} {}: ", time_text(utime), name, level);
    line += text;
    std::replace(line.begin(), line.end(), '\n', ' ');
  }
  return form.journal ? fmt::format("<{}>{}", priority(level), line) : line;
}

void log_line(std::string_view level, std::string_view text) {
  const auto line = log_text(log().form, utime_now(), log().name, level, text) + '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);  // One call: lines of threads do not mix.
}

}  // namespace voxatlas
