#include "base/log.hpp"

#include <fmt/chrono.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

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

std::optional<std::uint64_t> LogLimit::admit(const void* kind, std::int64_t now) {
  auto& lately = kinds_[kind];
  if (now - lately.since >= kPeriodUs) {
    lately.since = now;
    lately.lines = 0;
  }
  if (lately.lines == kLines) {
    ++lately.left_out;
    return std::nullopt;
  }
  ++lately.lines;
  return std::exchange(lately.left_out, 0);
}

void log_limited(std::string_view level, const void* kind, std::string_view text) {
  static std::mutex mutex;
  static LogLimit limit;  // Guarded by mutex.
  std::optional<std::uint64_t> left_out;
  {
    const std::lock_guard lock(mutex);
    left_out = limit.admit(kind, steady_utime());
  }
  if (!left_out) return;
  if (*left_out == 0) return log_line(level, text);
  log_line(level, fmt::format("{} (and {} more like it, not written)", text, *left_out));
}

void log_line(std::string_view level, std::string_view text) {
  const auto line = log_text(log().form, utime_now(), log().name, level, text) + '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);  // One call: lines of threads do not mix.
}

}  // namespace voxatlas
