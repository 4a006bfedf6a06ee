#include "render/render_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/endpoint.hpp"
#include "render/camera_message.hpp"

namespace voxatlas {
namespace {

constexpr std::int8_t kJpeg = 0, kPng = 1;
constexpr std::size_t kBatch = 64;  // Tiles fetched before the cache's room is looked at again.

double milliseconds_since(std::int64_t start) {
  return static_cast<double>(steady_utime() - start) / 1000;
}

/// What a request says beside its camera.
Status check(const render_request_t& request) {
  if (request.depth < 0 || request.depth > kDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("depth {} is not within 0..{}", request.depth, kDepth));
  }
  if (request.format != kJpeg && request.format != kPng) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("format {} is neither 0 (JPEG) nor 1 (PNG)", request.format));
  }
  if (request.format == kJpeg) return {};
  auto port = Endpoint::client_at(request.reply_port);
  return port ? Status{} : pass_on(port);
}

/// A reliable stream where the request names one that exists, else everyone.
std::int32_t way_back(const render_request_t& request) {
  const bool by_stream = request.format == kPng && Endpoint::client_at(request.reply_port);
  return by_stream ? request.reply_port : 0;
}

}  // namespace

void RenderService::on_request(const render_request_t& request) {
  ++requests_;
  const auto offer = queue_.offer(request);
  replaced_ += offer == RequestQueue::Offer::kReplaced;
  refused_ += offer == RequestQueue::Offer::kRefused;
}

void RenderService::on_tile_update(const tile_update_t& update) {
  const auto key = grid_.tile_from_morton(static_cast<std::uint64_t>(update.tile));
  if (key && update.version > 0) {
    directory_.update(*key, static_cast<std::uint64_t>(update.version));
  }
}

std::optional<OutgoingFrame> RenderService::work() {
  const auto request = queue_.take();
  if (!request) return std::nullopt;
  if (request->deadline > 0 && request->deadline < utime_now()) {
    ++expired_;
    return std::nullopt;
  }
  const std::int64_t start = steady_utime();
  OutgoingFrame out;
  out.reply_port = way_back(*request);
  frame_t& frame = out.frame;
  frame.client = request->client;
  frame.id = request->id;
  frame.sequence = sequence_++;
  frame.final = 1;
  frame.camera = request->camera;
  frame.depth = request->depth;
  frame.format = request->format;
  if (auto drawn = draw(*request, frame); !drawn) {
    ++bad_;
    frame.error = drawn.error().message;
    frame.data.clear();
  }
  frame.size = static_cast<std::int32_t>(frame.data.size());
  frame.utime = utime_now();
  ++frames_;
  last_frame_ms_ = milliseconds_since(start);
  return out;
}

Status RenderService::draw(const render_request_t& request, frame_t& frame) {
  if (auto good = check(request); !good) return good;
  auto colouring = colouring_of(request.colouring);
  if (!colouring) return pass_on(colouring);
  auto camera = to_camera(request.camera);
  if (!camera) return pass_on(camera);
  auto tiles = gather(*camera, frame);
  if (!tiles) return pass_on(tiles);
  auto image = paint(*camera, *tiles, request.depth, *colouring, frame);
  if (!image) return pass_on(image);
  const std::int64_t start = steady_utime();
  auto encoded = encode(*image, frame);
  frame.encode_ms = milliseconds_since(start);
  return encoded;
}

Result<Image> RenderService::paint(const Camera& camera, const Tiles& tiles, int depth,
                                   Colouring colouring, frame_t& frame) {
  std::int64_t start = steady_utime();
  CellImage cells;
  SplatOptions options;
  options.max_depth = depth;
  if (auto drawn = splatter_.draw(camera, grid_, tiles.trees, options, cells); !drawn) {
    return pass_on(drawn);
  }
  for (const PlacedTree& placed : tiles.trees) {
    frame.cells += static_cast<std::int64_t>(placed.tree->cell_count(depth));
  }
  frame.draw_ms = milliseconds_since(start);
  start = steady_utime();
  auto image = shade(cells, TreeNumbers(tiles.trees), camera, grid_,
                     scene_heights(camera, grid_, tiles.trees), colouring, splatter_.workers());
  frame.shade_ms = milliseconds_since(start);
  return image;
}

Status RenderService::encode(const Image& image, frame_t& frame) const {
  if (frame.format == kJpeg) {
    auto jpeg = encode_jpeg(image, config_.jpeg_quality, config_.jpeg_bytes);
    if (!jpeg) return pass_on(jpeg);
    frame.quality = static_cast<std::int8_t>(jpeg->quality);
    frame.data = std::move(jpeg->bytes);
    return {};
  }
  auto png = encode_png(image);
  if (!png) return pass_on(png);
  if (png->size() > config_.png_bytes) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("the PNG of {} x {} has {} bytes, more than the {} a stream takes",
                            image.width, image.height, png->size(), config_.png_bytes));
  }
  frame.data = std::move(*png);
  return {};
}

Result<RenderService::Tiles> RenderService::gather(const Camera& camera, frame_t& frame) {
  const std::int64_t until = steady_utime() + config_.fetch_us;
  std::int64_t start = steady_utime();
  auto in_view = look_up(camera, until);
  if (!in_view) return pass_on(in_view);
  frame.fetch_ms = milliseconds_since(start);
  cache_.begin_picture();
  Tiles tiles;
  std::size_t done = 0;
  while (done < in_view->size()) {
    cache_.trim();
    if (cache_.bytes() > cache_.budget()) break;  // This picture alone fills it.
    const auto first = in_view->begin() + static_cast<std::ptrdiff_t>(done);
    const std::size_t count = std::min(kBatch, in_view->size() - done);
    const std::vector<TileKey> batch(first, first + static_cast<std::ptrdiff_t>(count));
    start = steady_utime();
    fetch(batch, until);
    frame.fetch_ms += milliseconds_since(start);
    start = steady_utime();
    place(batch, tiles);
    frame.build_ms += milliseconds_since(start);
    done += count;
  }
  tiles.missing += static_cast<std::int32_t>(in_view->size() - done);
  tiles_missing_ += static_cast<std::uint64_t>(tiles.missing);
  frame.tiles = static_cast<std::int32_t>(tiles.trees.size());
  frame.tiles_missing = tiles.missing;
  frame.newest_version = static_cast<std::int64_t>(tiles.newest);
  return tiles;
}

Result<std::vector<TileKey>> RenderService::look_up(const Camera& camera, std::int64_t until) {
  const TileRange range = tiles_of(grid_, camera.bounds());
  const std::int64_t now = steady_utime();
  if (!directory_.knows(range, now)) {
    auto listed = source_.list(range, until - now);
    if (!listed) return pass_on(listed);
    directory_.take(range, *listed, steady_utime());
  }
  return tiles_in_view(camera, grid_, directory_.keys());
}

void RenderService::fetch(const std::vector<TileKey>& batch, std::int64_t until) {
  std::vector<TileKey> wanted;
  for (const TileKey key : batch) {
    if (cache_.version(key) < directory_.version(key)) wanted.push_back(key);
  }
  const std::int64_t timeout = until - steady_utime();
  if (wanted.empty() || timeout <= 0) return;
  const auto fetched = source_.fetch(wanted, timeout, [this](ArrivedTile tile) {
    ++tiles_fetched_;
    cache_.put(tile.key, tile.version, std::move(tile.bytes));
  });
  if (!fetched) log_warning("tiles did not all come: {}", fetched.error().message);
}

void RenderService::place(const std::vector<TileKey>& batch, Tiles& tiles) {
  for (const TileKey key : batch) {
    const std::uint64_t version = cache_.version(key);
    tiles.missing += version < directory_.version(key);
    if (version == 0) continue;
    auto tree = cache_.tree(key);
    if (!tree) {
      ++tiles_broken_;
      tiles.missing += version >= directory_.version(key);  // Counted once.
      log_warning("a tile is not drawn: {}", tree.error().message);
      continue;
    }
    tiles.trees.push_back({key, *tree});
    tiles.newest = std::max(tiles.newest, version);
  }
}

std::vector<std::pair<std::string, double>> RenderService::counters() const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  return {{"requests", number(requests_)},
          {"requests_waiting", number(queue_.size())},
          {"requests_replaced", number(replaced_)},
          {"requests_refused", number(refused_)},
          {"requests_expired", number(expired_)},
          {"requests_failed", number(bad_)},
          {"frames", number(frames_)},
          {"last_frame_ms", last_frame_ms_},
          {"tiles_fetched", number(tiles_fetched_)},
          {"tiles_missing", number(tiles_missing_)},
          {"tiles_broken", number(tiles_broken_)},
          {"cache_tiles", number(cache_.tiles())},
          {"cache_bytes", number(cache_.bytes())}};
}

}  // namespace voxatlas
