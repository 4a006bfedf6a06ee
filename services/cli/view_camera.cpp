#include "cli/view_camera.hpp"

#include <fmt/format.h>

#include <charconv>
#include <deque>
#include <utility>
#include <vector>

#include "cli/camera_track.hpp"
#include "cli/place_text.hpp"
#include "cli/progress.hpp"
#include "codec/tile_codec.hpp"
#include "geodesy/enu_frame.hpp"
#include "grid/region_key.hpp"
#include "render/cell_cloud.hpp"
#include "render/model_extent.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas {

namespace {

Result<ViewSize> parse_size(const std::string& text) {
  ViewSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    if (height.ec == std::errc{} && height.ptr == end) return size;
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("--size {}: give WIDTHxHEIGHT, such as 1280x720", text));
}

Result<std::vector<TileWeight>> weigh_tiles(ModelClient& client) {
  const Grid grid = client.parameters().grid();
  std::vector<TileWeight> weights;
  Status sound;
  Progress progress;
  std::size_t looked_at = 0;
  auto listed = client.for_each_tile(true, [&](const ModelClient::TileRow& row) {
    progress.say(fmt::format("looking for the view: {} tiles", ++looked_at));
    auto key = grid.tile_from_morton(row.key);
    if (!key) {
      sound = pass_on(key);
    } else if (row.occupied_voxels > 0) {
      weights.push_back({*key, row.occupied_voxels});
    }
  });
  if (!listed) return pass_on(listed);
  if (!sound) return pass_on(sound);
  return weights;
}

/// The clouds of some tiles, and the placed clouds that borrow them.
struct FetchedClouds {
  std::deque<CellCloud> clouds;  // Places stay valid as it grows.
  std::vector<PlacedCloud> placed;
};

Result<FetchedClouds> fetch_clouds(ModelClient& client, const std::vector<TileKey>& keys) {
  const auto& parameters = client.parameters();
  std::vector<std::pair<std::int32_t, std::int64_t>> wanted;
  for (const TileKey key : keys) {
    wanted.emplace_back(shard_of(key, parameters.shards), static_cast<std::int64_t>(key.morton()));
  }
  FetchedClouds result;
  Status sound;
  auto fetched = client.stores().fetch(
      wanted, ModelClient::kPatience, [&](const StoreClient::FetchedTile& tile) {
        if (tile.version == 0) return;
        auto key = parameters.grid().tile_from_morton(static_cast<std::uint64_t>(tile.tile));
        auto tree = decode_tile(tile.bytes);
        if (!key || !tree) {
          sound = key ? pass_on(tree, fmt::format("tile {:#x}", key->morton())) : pass_on(key);
          return;
        }
        result.placed.push_back({*key, &result.clouds.emplace_back(*tree, kDepth)});
      });
  if (!fetched) return pass_on(fetched);
  if (!sound) return pass_on(sound);
  return result;
}

/// Where most of the model lies, on its surface's middle.
Result<Eigen::Vector3d> middle_of_model(ModelClient& client) {
  auto weights = weigh_tiles(client);
  if (!weights) return pass_on(weights);
  auto extent = ModelExtent::of(client.parameters().grid(), *weights);
  if (!extent) return pass_on(extent);
  return extent->frame.origin_ecef();
}

Result<Eigen::Vector3d> place_of(const std::string& option, const std::string& text) {
  auto place = parse_place(option, text);
  if (!place) return pass_on(place);
  auto ecef = to_ecef(*place);
  return ecef ? Result<Eigen::Vector3d>(*ecef) : pass_on(ecef, option);
}

Lens lens_of(const RenderOptions& options, const ViewSize& size) {
  constexpr double kFov = 60;
  return Lens::of_view(options.fov > 0 ? options.fov : kFov, size.width, size.height);
}

/// Straight down from above everything, north up.
Result<Camera> map_camera(const Eigen::Vector3d& middle_ecef, double metres, const ViewSize& size) {
  constexpr double kAbove = 900;
  auto frame = EnuFrame::at(middle_ecef);
  if (!frame) return pass_on(frame);
  Lens lens = Lens::of_map(size.width / metres, size.width, size.height);
  lens.far_range = 2 * kAbove;
  return Camera::look_at(middle_ecef + kAbove * frame->up_ecef(), middle_ecef, frame->north_ecef(),
                         lens);
}

Result<Camera> camera_of_view(ModelClient& client, const RenderOptions& options,
                              const ViewSize& size) {
  const Grid grid = client.parameters().grid();
  auto weights = weigh_tiles(client);
  if (!weights) return pass_on(weights);
  if (options.view == "oblique") return oblique_view(grid, *weights, size);
  if (options.view != "street") {
    return fail(ErrorCode::kInvalid,
                fmt::format("--view {}: there are street and oblique", options.view));
  }
  auto fetched = fetch_clouds(client, street_tiles(grid, *weights));
  if (!fetched) return pass_on(fetched);
  return street_view(grid, *weights, fetched->placed, size);
}

Result<Camera> camera_at_place(const RenderOptions& options, const ViewSize& size) {
  if (options.look_at.empty()) {
    auto eye = parse_place("--at", options.at);
    if (!eye) return pass_on(eye);
    auto view = standing_view(*eye, options.heading, size);
    return view ? view : pass_on(view, "--at " + options.at);
  }
  auto eye = place_of("--at", options.at);
  if (!eye) return pass_on(eye);
  auto target = place_of("--look-at", options.look_at);
  if (!target) return pass_on(target);
  return Camera::look_at(*eye, *target, up_at(*eye), lens_of(options, size));
}

}  // namespace

Result<Camera> choose_camera(ModelClient& client, const RenderOptions& options) {
  auto size = parse_size(options.size);
  if (!size) return pass_on(size);
  if (options.map > 0) {
    auto middle = options.at.empty() ? middle_of_model(client) : place_of("--at", options.at);
    if (!middle) return pass_on(middle);
    return map_camera(*middle, options.map, *size);
  }
  if (!options.at.empty()) return camera_at_place(options, *size);
  return camera_of_view(client, options, *size);
}

Result<std::vector<Camera>> choose_track(ModelClient& client, const RenderOptions& options) {
  if (!options.path.empty()) {
    auto size = parse_size(options.size);
    if (!size) return pass_on(size);
    return read_track(options.path, options.rate, lens_of(options, *size));
  }
  auto first = choose_camera(client, options);
  if (!first) return pass_on(first);
  auto target =
      options.look_at.empty() ? middle_of_model(client) : place_of("--look-at", options.look_at);
  if (!target) return pass_on(target);
  return orbit(*first, *target, options.orbit);
}

}  // namespace voxatlas
