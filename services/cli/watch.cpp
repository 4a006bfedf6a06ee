#include "cli/watch.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>

#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/json_text.hpp"
#include "cli/status_board.hpp"

namespace voxatlas {

namespace {

/// Subscribes, then prints until a signal, `done`, or the time is over, which is an error.
template <class Message>
Status watch(const WatchOptions& options, const char* channel,
             const std::function<Status(const Message&)>& print,
             const std::function<bool()>& done) {
  auto bus = Bus::create(options.url);
  if (!bus) return pass_on(bus);
  Status printed;
  (*bus)->subscribe<Message>(channel, [&](const Message& message) {
    if (printed && !done()) printed = print(message);
  });
  const std::int64_t deadline =
      options.timeout > 0 ? steady_utime() + static_cast<std::int64_t>(options.timeout * 1e6)
                          : INT64_MAX;
  ServiceLoop loop;
  loop.buses = {bus->get()};
  loop.finished = done;
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    std::fflush(stdout);
    if (!printed) return pass_on(printed);
    if (now >= deadline && !done()) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("nothing more came on {} within {} s", channel, options.timeout));
    }
    return deadline;
  };
  return loop.run();
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

void print_tile(const tile_update_t& update, bool json) {
  const auto key = fmt::format("{:016x}", static_cast<std::uint64_t>(update.tile));
  if (!json) {
    constexpr const char* kContents[] = {"changed", "delta", "tile"};
    const auto content = update.content >= 0 && update.content <= 2 ? update.content : 0;
    fmt::print("tile {} version {}: {}, {} bytes\n", key, update.version, kContents[content],
               update.size);
    return;
  }
  JsonObject line;
  line.add("tile", key)
      .add("version", update.version)
      .add("shard", std::int64_t{update.shard})
      .add("content", std::int64_t{update.content})
      .add("bytes", std::int64_t{update.size});
  fmt::print("{}\n", line.text());
}

}  // namespace

Status watch_frames(const WatchOptions& options) {
  std::error_code failed;
  if (!options.out.empty()) std::filesystem::create_directories(options.out, failed);
  if (failed) {
    return fail(ErrorCode::kIo, fmt::format("{}: {}", options.out, failed.message()));
  }
  std::int64_t seen = 0;
  return watch<frame_t>(
      options, kFrameChannel,
      [&](const frame_t& frame) {
        ++seen;
        print_frame(frame, options.json);
        return keep_picture(frame, options.out);
      },
      [&] { return options.count > 0 && seen >= options.count; });
}

Status watch_tiles(const WatchOptions& options) {
  std::int64_t seen = 0;
  return watch<tile_update_t>(
      options, kTileUpdateChannel,
      [&](const tile_update_t& update) -> Status {
        ++seen;
        print_tile(update, options.json);
        return {};
      },
      [&] { return options.count > 0 && seen >= options.count; });
}

Status watch_status(const WatchOptions& options) {
  StatusBoard board;
  std::int64_t seen = 0;
  auto ended = watch<status_t>(
      options, kStatusChannel,
      [&](const status_t& status) -> Status {
        ++seen;
        board.note(status, steady_utime());
        board.print(status, options.json);
        return {};
      },
      [&] {
        return (options.count > 0 && seen >= options.count) ||
               (options.until_ready > 0 && board.ready(steady_utime()) >= options.until_ready);
      });
  if (!ended && options.until_ready > 0) {
    return pass_on(ended, fmt::format("{} of {} services are ready", board.ready(steady_utime()),
                                      options.until_ready));
  }
  return ended;
}

}  // namespace voxatlas
