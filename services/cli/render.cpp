#include "cli/render.hpp"

#include <fmt/format.h>

#include <fstream>
#include <optional>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/json_text.hpp"
#include "cli/model_client.hpp"
#include "cli/progress.hpp"
#include "cli/view_camera.hpp"
#include "render/shade.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kAskAgain = 2'000'000;  ///< Requests are plain: one may be lost.

camera_t to_message(const Camera& camera) {
  camera_t message{};
  const auto& lens = camera.lens();
  for (int axis = 0; axis < 3; ++axis) message.position[axis] = camera.position()[axis];
  const auto& turn = camera.orientation();
  const double wxyz[] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy(std::begin(wxyz), std::end(wxyz), message.orientation);
  message.fx = lens.fx;
  message.fy = lens.fy;
  message.cx = lens.cx;
  message.cy = lens.cy;
  message.width = lens.width;
  message.height = lens.height;
  message.near_range = lens.near_range;
  message.far_range = lens.far_range;
  return message;
}

/// Asks, and waits for the frame, by its reliable stream or broadcast; asks again where nothing
/// comes.
Result<frame_t> ask_for_frame(ModelClient& client, render_request_t request, double timeout) {
  const std::int64_t start = steady_utime();
  const auto patience = static_cast<std::int64_t>(timeout * 1e6);
  std::int64_t ask_at = start;
  std::optional<frame_t> frame;
  client.bus().subscribe<frame_t>(kFrameChannel, [&](const frame_t& broadcast) {
    if (broadcast.client == request.client) frame = broadcast;
  });
  Progress progress;
  ServiceLoop loop;
  loop.buses = {&client.bus(), &client.in().port()};
  loop.finished = [&] { return frame.has_value(); };
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    for (const auto& message : client.in().consumer().take()) {
      client.in().consumer().commit(message.session, message.number);
      auto decoded = decode_message<frame_t>(message.payload);
      if (message.kind == MessageKind::kFrame && decoded && decoded->client == request.client) {
        frame = std::move(*decoded);
      }
    }
    if (auto pumped = client.in().pump(now); !pumped) return pass_on(pumped);
    if (frame) return now;
    if (now - start > patience) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("no picture came within {} s: is a render service running? "
                              "(voxatlas watch status)",
                              timeout));
    }
    if (now >= ask_at) {
      ask_at = now + kAskAgain;
      request.utime = utime_now();
      request.deadline = request.utime + patience - (now - start);
      if (auto sent = client.bus().publish(kRenderRequestChannel, request); !sent) {
        return pass_on(sent);
      }
    }
    progress.say("waiting for the picture");
    return std::min(ask_at, client.in().consumer().next_poll(now));
  };
  if (auto ended = loop.run(); !ended) return pass_on(ended);
  if (!frame) return fail(ErrorCode::kUnavailable, "stopped");
  if (!frame->error.empty()) return fail(ErrorCode::kInvalid, frame->error);
  return *frame;
}

void print_summary(const frame_t& frame, const RenderOptions& options) {
  if (!options.json) {
    fmt::print(
        "{}: {} tiles, {} missing, {} cells at depth {}; fetch {:.1f}, build {:.1f}, "
        "draw {:.1f}, shade {:.1f}, encode {:.1f} ms\n",
        options.out, frame.tiles, frame.tiles_missing, frame.cells, frame.depth, frame.fetch_ms,
        frame.build_ms, frame.draw_ms, frame.shade_ms, frame.encode_ms);
    return;
  }
  JsonObject json;
  json.add("out", options.out)
      .add("width", std::int64_t{frame.camera.width})
      .add("height", std::int64_t{frame.camera.height})
      .add("depth", std::int64_t{frame.depth})
      .add("tiles", std::int64_t{frame.tiles})
      .add("tiles_missing", std::int64_t{frame.tiles_missing})
      .add("newest_version", frame.newest_version)
      .add("cells", frame.cells)
      .add("bytes", std::int64_t{frame.size})
      .add("fetch_ms", frame.fetch_ms)
      .add("build_ms", frame.build_ms)
      .add("draw_ms", frame.draw_ms)
      .add("shade_ms", frame.shade_ms)
      .add("encode_ms", frame.encode_ms);
  fmt::print("{}\n", json.text());
}

}  // namespace

Status run_render(const RenderOptions& options) {
  if (auto colouring = colouring_of(options.colouring); !colouring) return pass_on(colouring);
  auto client = ModelClient::connect(options.url);
  if (!client) return pass_on(client);
  auto camera = choose_camera(**client, options);
  if (!camera) return pass_on(camera);
  render_request_t request{};
  request.client = (*client)->id();
  request.id = 1;
  request.camera = to_message(*camera);
  request.depth = static_cast<std::int8_t>(options.depth);
  request.colouring = options.colouring;
  request.format = options.broadcast ? 0 : 1;
  request.reply_port = options.broadcast ? 0 : (*client)->port_offset();
  auto frame = ask_for_frame(**client, request, options.timeout);
  if (!frame) return pass_on(frame);
  std::ofstream out(options.out, std::ios::binary);
  out.write(reinterpret_cast<const char*>(frame->data.data()),
            static_cast<std::streamsize>(frame->data.size()));
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", options.out));
  print_summary(*frame, options);
  return {};
}

}  // namespace voxatlas
