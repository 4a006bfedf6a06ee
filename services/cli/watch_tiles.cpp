#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/json_text.hpp"
#include "cli/model_client.hpp"
#include "cli/place_text.hpp"
#include "cli/tile_follower.hpp"
#include "cli/watch.hpp"
#include "cli/watch_channel.hpp"
#include "octree/tile_hash.hpp"

namespace voxatlas {

namespace {

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

/// The tiles that a box touches.
Result<TileBox> tiles_of(const Box& box, const Grid& grid) {
  const auto min = grid.tile_at(box.min);
  if (!min) return fail(min.error().code, min.error().message);
  const auto max = grid.tile_at(box.max);
  if (!max) return fail(max.error().code, max.error().message);
  return TileBox{min->index(), max->index()};
}

Result<TileBox> wanted_tiles(const WatchOptions& options, const Grid& grid) {
  if (!options.box.empty()) {
    const auto box = parse_box("--box", options.box);
    if (!box) return fail(box.error().code, box.error().message);
    return tiles_of(*box, grid);
  }
  if (options.around.empty()) return TileBox{};
  const auto place = parse_place("--around", options.around);
  if (!place) return fail(place.error().code, place.error().message);
  const auto centre = to_ecef(*place);
  if (!centre) return fail(centre.error().code, centre.error().message);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(options.radius);
  return tiles_of(Box{*centre - reach, *centre + reach}, grid);
}

/// Written beside it first: who reads the file never sees half of it.
Status write_hashes(const TileMirror& mirror, const std::string& path) {
  const std::string partial = path + ".partial";
  std::ofstream out(partial);
  mirror.for_each([&](TileKey key, std::uint64_t version, const TileTree& tree) {
    out << fmt::format("{:016x} {} {}\n", key.morton(), version, to_hex(tile_hash(key, tree)));
  });
  out.close();
  if (!out || std::rename(partial.c_str(), path.c_str()) != 0) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path));
  }
  return {};
}

void print_in_step(const TileFollower& follower, std::int64_t now, bool json) {
  const auto& counters = follower.mirror().counters();
  const auto last = follower.last_update();
  const double after_ms = last == 0 ? 0 : static_cast<double>(now - last) / 1000;
  if (!json) {
    fmt::print(
        "in step: {} tiles; {} changes heard, {} applied, {} tiles fetched, {} lists, {:.0f} ms "
        "after the last change\n",
        follower.mirror().tiles(), counters.changes, counters.applied, counters.fetched,
        follower.lists(), after_ms);
    return;
  }
  JsonObject line;
  line.add("tiles", static_cast<std::int64_t>(follower.mirror().tiles()))
      .add("changes", static_cast<std::int64_t>(counters.changes))
      .add("applied", static_cast<std::int64_t>(counters.applied))
      .add("fetched", static_cast<std::int64_t>(counters.fetched))
      .add("gaps", static_cast<std::int64_t>(counters.gaps))
      .add("lists", static_cast<std::int64_t>(follower.lists()))
      .add("after_ms", after_ms);
  fmt::print("{}\n", line.text());
}

/// Says, and writes down, each time the copy has caught up.
class Follow {
 public:
  Follow(const WatchOptions& options, TileFollower& follower)
      : options_(options), follower_(follower) {}

  Result<std::int64_t> work(std::int64_t now) {
    if (auto caught_up = follower_.catch_up(); !caught_up) return pass_on(caught_up);
    now = std::max(now, steady_utime());
    const auto changes = follower_.mirror().counters().changes + follower_.lists();
    if (follower_.is_in_step() && told_ != changes) {
      told_ = changes;
      in_step_since_ = now;
      if (!options_.hashes.empty()) {
        if (auto written = write_hashes(follower_.mirror(), options_.hashes); !written) {
          return pass_on(written);
        }
      }
      print_in_step(follower_, now, options_.json);
      std::fflush(stdout);
    }
    return std::min(follower_.next_catch_up(), quiet_at());
  }

  bool is_over() const { return follower_.is_in_step() && steady_utime() >= quiet_at(); }

 private:
  /// When it will have been quiet for long enough; INT64_MAX: that is not asked for.
  std::int64_t quiet_at() const {
    if (options_.quiet <= 0 || !told_) return INT64_MAX;
    return std::max(in_step_since_, follower_.last_update()) +
           static_cast<std::int64_t>(options_.quiet * 1e6);
  }

  const WatchOptions& options_;
  TileFollower& follower_;
  std::optional<std::uint64_t> told_;  ///< What had changed when it was last in step.
  std::int64_t in_step_since_ = 0;
};

Status follow_tiles(const WatchOptions& options, ModelClient& client, const TileBox& box) {
  TileFollower follower(client, box, options.depth);
  Follow follow(options, follower);
  const auto until = watch_deadline(options);
  ServiceLoop loop;
  loop.buses = {&client.bus(), &client.in().port()};
  loop.finished = [&] { return follow.is_over(); };
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    if (now >= until) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("not in step and quiet within {} s", options.timeout));
    }
    auto again = follow.work(now);
    if (!again) return pass_on(again);
    return std::min(*again, until);
  };
  return loop.run();
}

}  // namespace

Status watch_tiles(const WatchOptions& options) {
  std::unique_ptr<ModelClient> client;
  TileBox box;
  if (options.follow || !options.box.empty() || !options.around.empty()) {
    auto connected = ModelClient::connect(options.url);
    if (!connected) return pass_on(connected);
    client = std::move(*connected);
    auto wanted = wanted_tiles(options, client->parameters().grid());
    if (!wanted) return pass_on(wanted);
    box = *wanted;
  }
  if (options.follow) return follow_tiles(options, *client, box);
  std::int64_t seen = 0;
  return watch_channel<tile_update_t>(
      options, kTileUpdateChannel,
      [&](const tile_update_t& update) -> Status {
        const auto key = TileKey::from_morton(static_cast<std::uint64_t>(update.tile));
        if (!key || !box.holds(*key)) return {};
        ++seen;
        print_tile(update, options.json);
        return {};
      },
      [&] { return options.count > 0 && seen >= options.count; });
}

}  // namespace voxatlas
