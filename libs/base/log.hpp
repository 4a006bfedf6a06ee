#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace voxatlas {

/// How a line begins, e.g. "tilestore[0]"; set once at start, before other threads run.
void set_log_name(std::string name);

/// One event, one line on standard error: "2026-11-22T02:34:11.123Z tilestore[0] info: text".
/// Line breaks in `text` become spaces, so that an event stays one line. Safe from any thread.
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
