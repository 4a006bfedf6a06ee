// What a client of the render service sees, on the running set.
//
//   render_probe latency   from a request to its frame at a subscriber, all tiles cached, less the
//                          time the frame itself took; alone, and beside a client who asks a
//                          thousand times a second
//   render_probe live      from a change that is durable to the frame that shows it, while scans
//                          come in; until a change is as old as --quiet. Changes count from when a
//                          frame shows all that was there when the stream was asked for, which is
//                          live_first_ms after that.
//
// Prints "name value unit" a line.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/frame_asker.hpp"
#include "cli/model_client.hpp"
#include "cli/view_camera.hpp"
#include "render/frustum.hpp"

namespace voxatlas {
namespace {

struct Options {
  RenderOptions render;
  int count = 20;
  int flood = 1000;     ///< Requests a second.
  double seconds = 60;  ///< Live: at most so long.
  double quiet = 2;     ///< Live: it ends when nothing has changed for so long.
  double rate = 10;
};

void check(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(const char* name, double value, const char* unit) {
  fmt::print("{} {:.4g} {}\n", name, value, unit);
}

render_request_t request_for(ModelClient& client, const Camera& camera, const Options& options) {
  render_request_t request{};
  request.client = client.id();
  request.camera = to_message(camera);
  request.depth = static_cast<std::int8_t>(options.render.depth);
  request.colouring = options.render.colouring;
  request.budget_ms = options.render.budget;
  return request;
}

/// Runs the bus until `done`, calling `step` at least every `every_us`.
void run_until(ModelClient& client, const std::function<bool()>& done, std::int64_t every_us,
               const std::function<void(std::int64_t)>& step) {
  constexpr std::int64_t kTooLong = 30'000'000;
  const std::int64_t start = steady_utime();
  ServiceLoop loop;
  loop.buses = {&client.bus()};
  loop.finished = done;
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    if (now - start > kTooLong) return fail(ErrorCode::kUnavailable, "no frame came within 30 s");
    step(now);
    return now + every_us;
  };
  check(loop.run());
}

struct Answer {
  double all_ms, frame_ms;
};

/// Asks once and waits for the frame, while others ask `flood` times a second.
Answer ask(ModelClient& client, render_request_t request, int flood) {
  static std::int64_t id = 100;
  request.id = ++id;
  std::optional<Answer> answer;
  std::int64_t start = 0;
  const auto heard = client.bus().subscribe<frame_t>(kFrameChannel, [&](const frame_t& frame) {
    if (frame.client != request.client || frame.id != request.id) return;
    if (!frame.error.empty()) throw std::runtime_error(frame.error);
    answer = {static_cast<double>(steady_utime() - start) / 1000,
              frame.draw_ms + frame.shade_ms + frame.overlay_ms + frame.encode_ms};
  });
  render_request_t other = request;
  other.client = request.client + 1;
  std::int64_t flooded = steady_utime();
  const std::int64_t ask_at = flooded + (flood > 0 ? 200'000 : 0);
  run_until(
      client, [&] { return answer.has_value(); }, 1'000,
      [&](std::int64_t now) {
        for (; flood > 0 && flooded < now; flooded += 1'000'000 / flood) {
          ++other.id;
          check(client.bus().publish(kRenderRequestChannel, other));
        }
        if (start == 0 && now >= ask_at) {
          request.utime = utime_now();
          start = steady_utime();
          check(client.bus().publish(kRenderRequestChannel, request));
        }
      });
  client.bus().unsubscribe(heard);
  return *answer;
}

void measure_latency(const Options& options) {
  auto client = or_throw(ModelClient::connect(options.render.url));
  const Camera camera = or_throw(choose_camera(*client, options.render));
  const auto request = request_for(*client, camera, options);
  for (int i = 0; i < 3; ++i) (void)ask(*client, request, 0);  // Everything is fetched and built.
  for (const int flood : {0, options.flood}) {
    std::vector<double> all, frame, overhead;
    for (int i = 0; i < options.count; ++i) {
      const Answer answer = ask(*client, request, flood);
      all.push_back(answer.all_ms);
      frame.push_back(answer.frame_ms);
      overhead.push_back(answer.all_ms - answer.frame_ms);
    }
    const std::string name = flood == 0 ? "request" : "flooded";
    print((name + "_to_frame_ms").c_str(), percentile(all, 0.5), "ms");
    print((name + "_frame_ms").c_str(), percentile(frame, 0.5), "ms");
    print((name + "_overhead_ms").c_str(), percentile(overhead, 0.5), "ms");
    print((name + "_to_frame_max_ms").c_str(), percentile(all, 1), "ms");
  }
}

void measure_live(const Options& options) {
  // A frame says until when all is shown that its renderer was told of: a change counts once that
  // is after we were told of it ourselves, and a little more, should the renderer be told later.
  constexpr std::int64_t kTelling = 20'000;
  struct Change {
    std::int64_t durable, heard;  // utime.
  };
  auto client = or_throw(ModelClient::connect(options.render.url));
  const Camera camera = or_throw(choose_camera(*client, options.render));
  const Grid grid = client->parameters().grid();
  std::vector<Change> pending;  // Those that are not shown yet.
  std::vector<double> delays;
  std::int64_t frames = 0, changed_at = 0, first_at = 0;
  const std::int64_t asked_at = utime_now();
  client->bus().subscribe<tile_update_t>(kTileUpdateChannel, [&](const tile_update_t& update) {
    const auto key = grid.tile_from_morton(static_cast<std::uint64_t>(update.tile));
    if (!key || tiles_in_view(camera, grid, std::array{*key}).empty()) return;
    pending.push_back({update.utime, utime_now()});
    changed_at = steady_utime();
  });
  auto request = request_for(*client, camera, options);
  client->bus().subscribe<frame_t>(kFrameChannel, [&](const frame_t& frame) {
    if (frame.client != request.client) return;
    if (!frame.error.empty()) throw std::runtime_error(frame.error);
    ++frames;
    const std::int64_t now = utime_now();
    const bool live = first_at > 0;  // Until then the view was being fetched, not kept live.
    if (!live && frame.shown_until >= asked_at) first_at = now;
    std::erase_if(pending, [&](const Change& change) {
      if (frame.shown_until < std::max(change.durable, change.heard) + kTelling) return false;
      if (live) delays.push_back(static_cast<double>(now - change.durable) / 1000);
      return true;
    });
  });
  request.id = 1;
  request.kind = 1;
  request.rate = options.rate;
  request.deadline = utime_now() + static_cast<std::int64_t>(options.seconds * 1e6);
  check(client->bus().publish(kRenderRequestChannel, request));
  const std::int64_t start = steady_utime();
  ServiceLoop loop;
  loop.buses = {&client->bus()};
  bool over = false;
  loop.finished = [&] { return over; };
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    const auto after = [now](std::int64_t then, double seconds) {
      return static_cast<double>(now - then) / 1e6 > seconds;
    };
    over = after(start, options.seconds) ||
           (changed_at > 0 && pending.empty() && after(changed_at, options.quiet));
    return now + 50'000;
  };
  check(loop.run());
  if (first_at == 0) throw std::runtime_error("no frame shows all that was there at its beginning");
  print("live_changes", static_cast<double>(delays.size()), "tiles");
  print("live_never_shown", static_cast<double>(pending.size()), "tiles");
  print("live_first_ms", static_cast<double>(first_at - asked_at) / 1000, "ms");
  print("live_frames", static_cast<double>(frames), "frames");
  print("live_median_ms", percentile(delays, 0.5), "ms");
  print("live_p95_ms", percentile(delays, 0.95), "ms");
  print("live_max_ms", percentile(delays, 1), "ms");
  const auto late = std::count_if(delays.begin(), delays.end(), [](double ms) { return ms > 500; });
  print("live_above_500ms", static_cast<double>(late), "tiles");
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Options options;
  options.render.url = voxatlas::kDefaultBusUrl;
  CLI::App app{"what a client of the render service sees"};
  app.require_subcommand(1);
  app.add_option("--url", options.render.url, "LCM URL")->envname("LCM_DEFAULT_URL");
  app.add_option("--view", options.render.view, "street or oblique");
  app.add_option("--at", options.render.at, "LAT,LON,HEIGHT");
  app.add_option("--look-at", options.render.look_at, "LAT,LON,HEIGHT");
  app.add_option("--size", options.render.size, "WIDTHxHEIGHT");
  app.add_option("--budget", options.render.budget, "milliseconds a picture");
  auto* latency = app.add_subcommand("latency", "from a request to its frame");
  latency->add_option("--count", options.count, "requests")->check(CLI::Range(1, 10'000));
  latency->add_option("--flood", options.flood, "requests a second of another client");
  auto* live = app.add_subcommand("live", "from a change to the frame that shows it");
  live->add_option("--seconds", options.seconds, "at most");
  live->add_option("--quiet", options.quiet, "end when nothing has changed for so long, seconds");
  live->add_option("--rate", options.rate, "pictures a second");
  CLI11_PARSE(app, argc, argv);
  try {
    if (*latency) voxatlas::measure_latency(options);
    if (*live) voxatlas::measure_live(options);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "render_probe: {}\n", e.what());
    return 1;
  }
}
