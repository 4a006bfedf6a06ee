#include "cli/view_camera.hpp"

#include <fmt/format.h>

#include <charconv>
#include <deque>
#include <utility>
#include <vector>

#include "cli/place_text.hpp"
#include "codec/tile_codec.hpp"
#include "grid/region_key.hpp"
#include "render/cell_cloud.hpp"
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
  auto listed = client.for_each_tile(true, [&](const ModelClient::TileRow& row) {
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

}  // namespace

Result<Camera> choose_camera(ModelClient& client, const RenderOptions& options) {
  auto size = parse_size(options.size);
  if (!size) return pass_on(size);
  if (!options.at.empty()) {
    auto eye = parse_place("--at", options.at);
    if (!eye) return pass_on(eye);
    return standing_view(*eye, options.heading, *size);
  }
  const Grid grid = client.parameters().grid();
  auto weights = weigh_tiles(client);
  if (!weights) return pass_on(weights);
  if (options.view == "oblique") return oblique_view(grid, *weights, *size);
  if (options.view != "street") {
    return fail(ErrorCode::kInvalid,
                fmt::format("--view {}: there are street and oblique", options.view));
  }
  auto fetched = fetch_clouds(client, street_tiles(grid, *weights));
  if (!fetched) return pass_on(fetched);
  return street_view(grid, *weights, fetched->placed, *size);
}

}  // namespace voxatlas
