#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "../../render/scene.hpp"
#include "codec/tile_codec.hpp"
#include "render/render_service.hpp"

namespace voxatlas::test {

/// Tile stores of one process: a map of tiles, and what was asked of it.
struct MapOfTiles {
  std::map<TileKey, std::pair<std::uint64_t, Bytes>> tiles;
  std::set<TileKey> silent;  ///< Tiles that never come.
  bool lists = true;
  int listed = 0;
  std::vector<TileKey> fetched;

  explicit MapOfTiles(const Scene& scene) {
    for (const auto& [key, tree] : scene.tiles()) tiles[key] = {1, encode_tile(tree, {})};
  }

  TileSource source() {
    TileSource source;
    source.list = [this](const TileRange& range, std::int64_t) -> Result<std::vector<ListedTile>> {
      ++listed;
      if (!lists) return fail(ErrorCode::kUnavailable, "tilestore 0 has not answered");
      std::vector<ListedTile> found;
      for (const auto& [key, tile] : tiles) {
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          inside = inside && key.index()[axis] >= range.min[axis] &&
                   key.index()[axis] <= range.max[axis];
        }
        if (inside) found.push_back({key, tile.first});
      }
      return found;
    };
    source.fetch = [this](const std::vector<TileKey>& keys, std::int64_t,
                          const std::function<void(ArrivedTile)>& arrived) -> Status {
      bool all = true;
      for (const TileKey key : keys) {
        fetched.push_back(key);
        all = all && !silent.contains(key);
        if (silent.contains(key)) continue;
        arrived({key, tiles.at(key).first, tiles.at(key).second});
      }
      if (!all) return fail(ErrorCode::kUnavailable, "some tiles did not come");
      return {};
    };
    return source;
  }
};

inline camera_t message_of(const Camera& camera) {
  camera_t message{};
  for (int axis = 0; axis < 3; ++axis) message.position[axis] = camera.position()[axis];
  message.orientation[0] = camera.orientation().w();
  message.orientation[1] = camera.orientation().x();
  message.orientation[2] = camera.orientation().y();
  message.orientation[3] = camera.orientation().z();
  const Lens& lens = camera.lens();
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

/// A renderer over the street scene, and a request for a picture of it.
struct RenderBench {
  Scene scene = street_scene();
  Camera camera = scene.camera({-20, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200)).value();
  MapOfTiles map{scene};
  std::unique_ptr<RenderService> service;

  explicit RenderBench(const RenderConfig& config = {}) {
    service = std::make_unique<RenderService>(scene.grid(), map.source(), config);
  }

  render_request_t request() const {
    render_request_t request{};
    request.client = 77;
    request.id = 5;
    request.camera = message_of(camera);
    request.depth = 7;
    request.colouring = "rgb";
    return request;
  }

  frame_t frame(const render_request_t& request) {
    service->on_request(request);
    auto out = service->work();
    REQUIRE(out.has_value());
    return out->frame;
  }
};

}  // namespace voxatlas::test
