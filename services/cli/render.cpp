#include "cli/render.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/camera_track.hpp"
#include "cli/frame_asker.hpp"
#include "cli/json_text.hpp"
#include "cli/model_client.hpp"
#include "cli/view_camera.hpp"
#include "render/shade.hpp"

namespace voxatlas {

namespace {

constexpr std::int8_t kJpeg = 0, kPng = 1, kRaw = 2;
constexpr std::int8_t kSteps = 1, kMetres = 2;
/// A path's pictures are wanted as fast as they come; the service draws no faster than this.
constexpr double kFastest = 60;

bool ends_in(const std::string& text, std::string_view end) {
  return text.size() >= end.size() &&
         std::string_view(text).substr(text.size() - end.size()) == end;
}

bool many(const RenderOptions& options) { return options.orbit > 0 || !options.path.empty(); }

Status check(const RenderOptions& options) {
  if (auto colouring = colouring_of(options.colouring); !colouring) return pass_on(colouring);
  if (options.backend != "splat" && options.backend != "gl") {
    return fail(ErrorCode::kInvalid,
                fmt::format("--backend {}: there are splat and gl", options.backend));
  }
  if (options.broadcast && !options.depth_image.empty()) {
    return fail(ErrorCode::kInvalid, "--depth-image comes by stream only: leave out --broadcast");
  }
  if (many(options) && !options.depth_image.empty()) {
    return fail(ErrorCode::kInvalid, "--depth-image is of one picture: leave out --path, --orbit");
  }
  return {};
}

render_request_t request_of(const RenderOptions& options, const ModelClient& client) {
  render_request_t request{};
  request.client = client.id();
  request.id = 1;
  request.depth = static_cast<std::int8_t>(options.depth);
  request.budget_ms = options.budget;
  request.colouring = options.colouring;
  request.backend = options.backend == "gl" ? 1 : 0;
  request.fill_holes = options.fill_holes ? 1 : 0;
  request.free_depth = static_cast<std::int8_t>(options.free_depth);
  request.overlay = static_cast<std::int8_t>(1 * options.boxes + 2 * options.axes +
                                             4 * options.north + 8 * options.scale);
  const bool jpeg = options.broadcast || (!many(options) && ends_in(options.out, ".jpg"));
  request.format = jpeg ? kJpeg : !many(options) && ends_in(options.out, ".raw") ? kRaw : kPng;
  request.reply_port = options.broadcast ? 0 : client.port_offset();
  if (!options.depth_image.empty()) {
    request.depth_format = ends_in(options.depth_image, ".u16") ? kSteps : kMetres;
  }
  return request;
}

Status write_file(const std::filesystem::path& path, ByteView bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path.string()));
  return {};
}

void print_summary(const frame_t& frame, const std::string& out, bool as_json) {
  if (!as_json) {
    fmt::print(
        "{}: {} tiles, {} missing, {} cells at depth {}; waited {:.1f}, of it for tiles {:.1f}, "
        "draw {:.1f}, shade {:.1f}, encode {:.1f} ms\n",
        out, frame.tiles, frame.tiles_missing, frame.cells, frame.depth, frame.wait_ms,
        frame.fetch_ms, frame.draw_ms, frame.shade_ms, frame.encode_ms);
    return;
  }
  JsonObject json;
  json.add("out", out)
      .add("width", std::int64_t{frame.camera.width})
      .add("height", std::int64_t{frame.camera.height})
      .add("depth", std::int64_t{frame.depth})
      .add("samples", std::int64_t{frame.samples})
      .add("sequence", frame.sequence)
      .add("place", std::int64_t{frame.place})
      .add("renderer", std::int64_t{frame.renderer})
      .add("tiles", std::int64_t{frame.tiles})
      .add("tiles_missing", std::int64_t{frame.tiles_missing})
      .add("newest_version", frame.newest_version)
      .add("cells", frame.cells)
      .add("bytes", std::int64_t{frame.size})
      .add("depth_scale", frame.depth_scale)
      .add("over_budget", std::int64_t{frame.over_budget})
      .add("wait_ms", frame.wait_ms)
      .add("fetch_ms", frame.fetch_ms)
      .add("draw_ms", frame.draw_ms)
      .add("shade_ms", frame.shade_ms)
      .add("overlay_ms", frame.overlay_ms)
      .add("encode_ms", frame.encode_ms);
  fmt::print("{}\n", json.text());
}

/// The best picture of a camera that rests: with a budget the last of several.
Status render_one(ModelClient& client, const Camera& camera, const RenderOptions& options) {
  auto request = request_of(options, client);
  request.camera = to_message(camera);
  std::optional<frame_t> best;
  auto came =
      ask_for_frames(client, std::move(request), options.timeout, [&](const frame_t& frame) {
        best = frame;
        return Status{};
      });
  if (!came) return came;
  if (auto written = write_file(options.out, best->data); !written) return written;
  if (!options.depth_image.empty()) {
    auto written = write_file(options.depth_image, best->depth_data);
    if (!written) return written;
  }
  print_summary(*best, options.out, options.json);
  return {};
}

/// A picture of each camera, numbered from 0, in a folder.
Status render_track(ModelClient& client, const std::vector<Camera>& track,
                    const RenderOptions& options) {
  std::error_code failed;
  std::filesystem::create_directories(options.out, failed);
  if (failed) return fail(ErrorCode::kIo, fmt::format("{}: {}", options.out, failed.message()));
  auto request = request_of(options, client);
  request.kind = 1;
  request.rate = kFastest;
  request.camera = to_message(track.front());
  auto rows = path_rows(track, kFastest);
  if (!rows) return pass_on(rows);
  request.path = std::move(*rows);
  request.path_size = static_cast<std::int32_t>(request.path.size());
  const char* ending = options.broadcast ? "jpg" : "png";
  return ask_for_frames(client, std::move(request), options.timeout, [&](const frame_t& frame) {
    const auto file =
        std::filesystem::path(options.out) / fmt::format("frame_{:06}.{}", frame.place, ending);
    auto written = write_file(file, frame.data);
    if (written) print_summary(frame, file.string(), options.json);
    return written;
  });
}

}  // namespace

Status run_render(const RenderOptions& options) {
  if (auto good = check(options); !good) return good;
  auto client = ModelClient::connect(options.url);
  if (!client) return pass_on(client);
  if (many(options)) {
    auto track = choose_track(**client, options);
    if (!track) return pass_on(track);
    return render_track(**client, *track, options);
  }
  auto camera = choose_camera(**client, options);
  if (!camera) return pass_on(camera);
  return render_one(**client, *camera, options);
}

}  // namespace voxatlas
