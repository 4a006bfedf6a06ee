#include "cli/watch.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "cli/json_text.hpp"
#include "cli/status_board.hpp"
#include "cli/watch_channel.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kTableEveryUs = 500'000;

std::size_t terminal_width() {
  constexpr std::size_t kUsual = 80;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
  return size.ws_col;
}

}  // namespace

Status watch_status(const WatchOptions& options) {
  const bool is_table = !options.json && isatty(STDOUT_FILENO) == 1;
  StatusBoard board;
  std::int64_t seen = 0, next_table = 0;
  const auto print = [&](const status_t& status) -> Status {
    const auto name = fmt::format("{} {}", status.service, status.index);
    if (!options.only.empty() && name != options.only) return {};
    ++seen;
    board.note(status, steady_utime());
    if (options.json) fmt::print("{}\n", status_json(status));
    if (!options.json && !is_table) fmt::print("{}\n", status_line(status));
    return {};
  };
  const auto done = [&] {
    return (options.count > 0 && seen >= options.count) ||
           (options.until_ready > 0 && board.ready(steady_utime()) >= options.until_ready);
  };
  const auto draw = [&](std::int64_t now) {
    if (!is_table) return std::int64_t{INT64_MAX};
    if (now >= next_table) {
      next_table = now + kTableEveryUs;
      fmt::print("\x1b[H\x1b[J{}", board.table(now, terminal_width()));  // From the top, cleared.
    }
    return next_table;
  };
  auto ended = watch_channel<status_t>(options, kStatusChannel, print, done, draw);
  if (!ended && options.until_ready > 0) {
    return pass_on(ended, fmt::format("{} of {} services are ready", board.ready(steady_utime()),
                                      options.until_ready));
  }
  return ended;
}

}  // namespace voxatlas
