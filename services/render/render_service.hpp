#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "grid/grid.hpp"
#include "render/image.hpp"
#include "render/request_queue.hpp"
#include "render/shade.hpp"
#include "render/splatter.hpp"
#include "render/tile_directory.hpp"
#include "render/tile_source.hpp"
#include "render/tree_cache.hpp"

namespace voxatlas {

struct RenderConfig {
  std::size_t cache_bytes = std::size_t{256} << 20;
  std::size_t threads = 2;                        ///< That draw and shade.
  std::size_t jpeg_bytes = 150'000;               ///< Of a broadcast frame's picture, at most.
  int jpeg_quality = 85;                          ///< Where that fits.
  std::size_t png_bytes = std::size_t{60} << 20;  ///< What a reliable stream's consumer takes.
  std::int64_t fetch_us = 3'000'000;              ///< For all tiles of a picture.
};

/// A frame and where it goes.
struct OutgoingFrame {
  frame_t frame{};
  std::int32_t reply_port = 0;  ///< 0: to everyone, on VOXATLAS_FRAME; else by reliable stream.
};

/// Draws what is asked for: requests and tile updates in, frames out.
///
/// Order:   the newest request of each client, clients in turn. Every request that is not replaced,
///          refused (too many clients) or past its deadline is answered, a bad one by a frame
///          without picture whose `error` says why.
/// Tiles:   those in view, nearest first, of the newest version known from listings and updates;
///          what does not come in time, or has no room in the cache, is counted in tiles_missing;
///          an older version that is here is drawn instead.
/// Threads: one at a time; `source` may call on_request and on_tile_update while it waits.
class RenderService {
 public:
  RenderService(const Grid& grid, TileSource source, const RenderConfig& config)
      : grid_(grid),
        source_(std::move(source)),
        config_(config),
        splatter_(config.threads),
        cache_(config.cache_bytes) {}

  void on_request(const render_request_t& request);
  void on_tile_update(const tile_update_t& update);

  bool idle() const { return queue_.empty(); }
  /// Draws the next picture, if one waits whose deadline (utime) has not passed.
  std::optional<OutgoingFrame> work();

  std::vector<std::pair<std::string, double>> counters() const;

 private:
  struct Tiles {
    std::vector<PlacedTree> trees;
    std::int32_t missing = 0;
    std::uint64_t newest = 0;
  };

  Status draw(const render_request_t& request, frame_t& frame);
  Status encode(const Image& image, frame_t& frame) const;
  Result<Tiles> gather(const Camera& camera, frame_t& frame);
  Result<Image> paint(const Camera& camera, const Tiles& tiles, int depth, Colouring colouring,
                      frame_t& frame);
  Result<std::vector<TileKey>> look_up(const Camera& camera, std::int64_t until);
  void fetch(const std::vector<TileKey>& batch, std::int64_t until);
  void place(const std::vector<TileKey>& batch, Tiles& tiles);

  Grid grid_;
  TileSource source_;
  RenderConfig config_;
  Splatter splatter_;
  TreeCache cache_;
  TileDirectory directory_;
  RequestQueue queue_;
  std::int64_t sequence_ = 0;
  std::uint64_t requests_ = 0, replaced_ = 0, refused_ = 0, expired_ = 0, bad_ = 0;
  std::uint64_t frames_ = 0, tiles_fetched_ = 0, tiles_missing_ = 0, tiles_broken_ = 0;
  double last_frame_ms_ = 0;
};

}  // namespace voxatlas
