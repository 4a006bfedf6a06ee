#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace voxatlas {

/// How an event is written down; each is one line.
struct LogForm {
  /// {"level":"info","service":"tilestore[0]","text":"...","time":"..."}, instead of
  /// "2026-11-22T02:34:11.123Z tilestore[0] info: text".
  bool json = false;
  /// With the journal's priority in front, "<6>"; the plain form leaves time and name to the
  /// journal.
  bool journal = false;
};

/// How a line begins, e.g. "tilestore[0]"; set once at start, before other threads run.
void set_log_name(std::string name);

/// From now on JSON; set at start, before other threads run. Whether the journal reads is not set
/// but seen: systemd says so in JOURNAL_STREAM.
void log_as_json();

/// One event as one line, without its end: line breaks in `text` become spaces, and in JSON what is
/// no UTF-8 is replaced. `level`: error, warning or info.
std::string log_text(LogForm form, std::int64_t utime, std::string_view name,
                     std::string_view level, std::string_view text);

/// Keeps a flood out of the log: who sends a thousand bad messages a second shall not fill the
/// disk. Of events of one kind so many lines are written in a period, and the next line after it
/// says how many were not.
class LogLimit {
 public:
  static constexpr int kLines = 10;
  static constexpr std::int64_t kPeriodUs = 10'000'000;

  /// Whether an event of this kind may be written now, and then how many before it were not.
  std::optional<std::uint64_t> admit(const void* kind, std::int64_t now);

 private:
  struct Kind {
    std::int64_t since = 0;
    int lines = 0;
    std::uint64_t left_out = 0;
  };
  std::map<const void*, Kind> kinds_;
};

/// Writes one event on standard error. Safe from any thread.
void log_line(std::string_view level, std::string_view text);
/// The same within a LogLimit; an event's kind is the place in the code that tells of it.
void log_limited(std::string_view level, const void* kind, std::string_view text);

template <class... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
  log_line("info", fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
  log_limited("warning", fmt::string_view(format).data(),
              fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
void log_error(fmt::format_string<Args...> format, Args&&... args) {
  log_limited("error", fmt::string_view(format).data(),
              fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace voxatlas
