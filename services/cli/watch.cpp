#include "cli/watch.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>

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

void print_frame(const frame_t& frame, bool json) {
  if (!json) {
    fmt::print("frame {}: {}x{}, depth {}, {} tiles, {} missing, {} bytes{}{}\n", frame.sequence,
               frame.camera.width, frame.camera.height, frame.depth, frame.tiles,
               frame.tiles_missing, frame.size, frame.error.empty() ? "" : ": ", frame.error);
    return;
  }
  JsonObject line;
  line.add("sequence", frame.sequence)
      .add("client", frame.client)
      .add("id", frame.id)
      .add("width", std::int64_t{frame.camera.width})
      .add("height", std::int64_t{frame.camera.height})
      .add("depth", std::int64_t{frame.depth})
      .add("tiles", std::int64_t{frame.tiles})
      .add("tiles_missing", std::int64_t{frame.tiles_missing})
      .add("final", std::int64_t{frame.final})
      .add("bytes", std::int64_t{frame.size})
      .add("error", frame.error);
  fmt::print("{}\n", line.text());
}

Status keep_picture(const frame_t& frame, const std::string& folder) {
  if (folder.empty() || frame.data.empty()) return {};
  const auto path = std::filesystem::path(folder) / fmt::format("frame_{:06}.{}", frame.sequence,
                                                                frame.format == 1 ? "png" : "jpg");
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(frame.data.data()),
            static_cast<std::streamsize>(frame.data.size()));
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path.string()));
  return {};
}

}  // namespace

Status watch_frames(const WatchOptions& options) {
  std::error_code failed;
  if (!options.out.empty()) std::filesystem::create_directories(options.out, failed);
  if (failed) {
    return fail(ErrorCode::kIo, fmt::format("{}: {}", options.out, failed.message()));
  }
  std::int64_t seen = 0;
  return watch_channel<frame_t>(
      options, kFrameChannel,
      [&](const frame_t& frame) {
        ++seen;
        print_frame(frame, options.json);
        return keep_picture(frame, options.out);
      },
      [&] { return options.count > 0 && seen >= options.count; });
}

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
