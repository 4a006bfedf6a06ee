#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bus/channels.hpp"
#include "cli/block_text.hpp"
#include "cli/json_text.hpp"
#include "cli/watch_channel.hpp"
#include "render/image.hpp"

namespace voxatlas {
namespace {

void print_frame(const frame_t& frame, bool json) {
  if (!json) {
    fmt::print("frame {} of request {}: {}x{}, depth {}, {} tiles, {} missing, {} bytes{}{}\n",
               frame.sequence, frame.id, frame.camera.width, frame.camera.height, frame.depth,
               frame.tiles, frame.tiles_missing, frame.size, frame.error.empty() ? "" : ": ",
               frame.error);
    return;
  }
  JsonObject line;
  line.add("utime", frame.utime)
      .add("sequence", frame.sequence)
      .add("client", frame.client)
      .add("id", frame.id)
      .add("renderer", std::int64_t{frame.renderer})
      .add("place", std::int64_t{frame.place})
      .add("width", std::int64_t{frame.camera.width})
      .add("height", std::int64_t{frame.camera.height})
      .add("depth", std::int64_t{frame.depth})
      .add("samples", std::int64_t{frame.samples})
      .add("tiles", std::int64_t{frame.tiles})
      .add("tiles_missing", std::int64_t{frame.tiles_missing})
      .add("newest_version", frame.newest_version)
      .add("shown_until", frame.shown_until)
      .add("final", std::int64_t{frame.final})
      .add("last", std::int64_t{frame.last})
      .add("over_budget", std::int64_t{frame.over_budget})
      .add("wait_ms", frame.wait_ms)
      .add("draw_ms", frame.draw_ms)
      .add("shade_ms", frame.shade_ms)
      .add("encode_ms", frame.encode_ms)
      .add("quality", std::int64_t{frame.quality})
      .add("bytes", std::int64_t{frame.size})
      .add("error", frame.error);
  fmt::print("{}\n", line.text());
}

/// Numbered as they come: a frame's own number counts within its request.
Status keep_picture(const frame_t& frame, const std::string& folder, std::int64_t number) {
  if (folder.empty() || frame.data.empty()) return {};
  const auto path = std::filesystem::path(folder) / fmt::format("frame_{:06}.jpg", number);
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(frame.data.data()),
            static_cast<std::streamsize>(frame.data.size()));
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path.string()));
  return {};
}

/// As wide as the terminal, but not so that a picture is higher than it; 80 where there is none.
int columns_for(const Image& image) {
  winsize size{};
  constexpr int kElsewhere = 80;
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kElsewhere;
  const int by_height =
      size.ws_row > 2 ? 2 * (size.ws_row - 2) * image.width / image.height : kElsewhere;
  return std::max(1, std::min<int>(size.ws_col, by_height));
}

Status show_blocks(const frame_t& frame) {
  if (frame.data.empty()) return {};
  auto image = decode_jpeg(frame.data);
  if (!image) return pass_on(image, "a frame");
  if (::isatty(STDOUT_FILENO) != 0) fmt::print("\033[H\033[2J");  // In the place of the last.
  fmt::print("{}", block_text(*image, columns_for(*image)));
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
        auto kept = keep_picture(frame, options.out, seen++);
        if (kept && options.blocks) kept = show_blocks(frame);
        print_frame(frame, options.json);
        return kept;
      },
      [&] { return options.count > 0 && seen >= options.count; });
}

}  // namespace voxatlas
