#pragma once

#include <fmt/format.h>

#include <cstdint>
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

/// Writes one event on standard error. Safe from any thread.
void log_line(std::string_view level, std::string_view text);

template <class... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
  log_line("info", fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
  log_line("warning", fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
void log_error(fmt::format_string<Args...> format, Args&&... args) {
  log_line("error", fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace voxatlas
