#include "tilestore/tile_queries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/log.hpp"
#include "base/utime.hpp"

namespace voxatlas {

namespace {

constexpr std::size_t kPlainRowBytes = 16;
constexpr std::size_t kDetailedRowBytes = 80;
constexpr std::size_t kMaxRowsBytes = 56'000;
constexpr std::size_t kMaxPayloadBytes = 59'000;
constexpr std::size_t kListedAtOnce = 256;
constexpr std::size_t kDetailedAtOnce = 4;  // Listing reads tiles, and few fit a page's time.
constexpr std::int64_t kPatience = 50'000;  // The journal must not wait longer for one page.

/// The box of a request as keys: every tile in it has a code between the two corners' codes.
struct KeyBox {
  Index3 min{}, max{};

  bool holds(TileKey key) const {
    const Index3 index = key.index();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (index[axis] < min[axis] || index[axis] > max[axis]) return false;
    }
    return true;
  }
};

Result<KeyBox> box_of(const tiles_request_t& request, const Grid& grid) {
  KeyBox box;
  const auto last = static_cast<std::int32_t>(grid.tiles_per_axis()) - 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto lower = std::max(request.min_index[axis], 0);
    const auto upper = std::min(request.max_index[axis], last);
    if (lower > upper) {
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("tiles_request_t: axis {}: from index {} to {}", axis,
                              request.min_index[axis], request.max_index[axis]));
    }
    box.min[axis] = static_cast<std::uint32_t>(lower);
    box.max[axis] = static_cast<std::uint32_t>(upper);
  }
  return box;
}

std::uint32_t capped(std::uint64_t count) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(count, UINT32_MAX));
}

}  // namespace

TileQueries::TileQueries(Atlas& atlas, TileStore& store)
    : atlas_(atlas), store_(store), contents_(atlas), encodings_(atlas) {}

Result<model_reply_t> TileQueries::answer(const model_request_t& request) {
  auto disk_bytes = store_.disk_bytes();
  if (!disk_bytes) return pass_on(disk_bytes);
  model_reply_t reply{};
  reply.utime = utime_now();
  reply.client = request.client;
  reply.id = request.id;
  reply.shard = static_cast<std::int32_t>(atlas_.shard());
  reply.epoch = static_cast<std::int64_t>(atlas_.epoch());
  reply.mark = request.source.empty() ? -1 : atlas_.mark(request.source, request.session);
  if (request.claim == 1) claims_.claim(request.source, request.client, steady_utime());
  if (request.claim == 2) claims_.give_back(request.source, request.client);
  reply.holder = claims_.holder(request.source, steady_utime());
  if (request.claim == 1 && reply.holder == request.client) check_mark(request, reply.mark);
  reply.disk_bytes = static_cast<std::int64_t>(*disk_bytes);
  reply.parameters = encode_parameters(atlas_.parameters());
  reply.size = static_cast<std::int32_t>(reply.parameters.size());
  return reply;
}

void TileQueries::check_mark(const model_request_t& request, std::int64_t mark) {
  if (mark >= request.acked_below - 1) return;
  ++marks_regressed_;
  log_error(
      "ALARM: acknowledged scans are lost: {}, session {}: all below {} were acknowledged, "
      "this shard has them up to {}",
      request.source, request.session, request.acked_below, mark);
}

Result<tiles_reply_t> TileQueries::answer(const tiles_request_t& request) {
  auto box = box_of(request, atlas_.parameters().grid());
  if (!box) return pass_on(box);
  tiles_reply_t reply{};
  reply.utime = utime_now();
  reply.client = request.client;
  reply.id = request.id;
  reply.shard = static_cast<std::int32_t>(atlas_.shard());
  reply.details = request.details;
  const bool details = request.details == 1;
  const std::size_t row_bytes = details ? kDetailedRowBytes : kPlainRowBytes;
  const std::uint64_t last_code = morton_encode(box->max);
  std::uint64_t from = std::max(static_cast<std::uint64_t>(std::max<std::int64_t>(request.from, 0)),
                                morton_encode(box->min));
  const std::int64_t until = steady_utime() + kPatience;

  for (bool room = true; room && from <= last_code;) {
    auto first = TileKey::from_morton(from);
    if (!first) return pass_on(first);
    auto listed = atlas_.list(*first, details ? kDetailedAtOnce : kListedAtOnce);
    if (!listed) return pass_on(listed);
    if (listed->empty()) from = last_code + 1;
    for (const TileInfo& tile : *listed) {
      if (box->holds(tile.key)) {
        if (auto added = add_row(tile, details, reply.rows); !added) return pass_on(added);
        ++reply.tiles;
      }
      from = tile.key.morton() + 1;
      room = reply.rows.size() + row_bytes <= kMaxRowsBytes && steady_utime() < until;
      if (!room) break;
    }
  }
  reply.next = from > last_code ? -1 : static_cast<std::int64_t>(from);
  reply.size = static_cast<std::int32_t>(reply.rows.size());
  return reply;
}

Status TileQueries::add_row(const TileInfo& tile, bool details, Bytes& rows) {
  ByteWriter writer(rows);
  writer.put(tile.key.morton());
  writer.put(tile.version);
  if (!details) return {};
  auto encoded = atlas_.encoded(tile.key);
  if (!encoded) return pass_on(encoded);
  auto contents = contents_.of(tile);
  if (!contents) return pass_on(contents);
  writer.put_bytes(contents->hash);
  writer.put(capped(encoded->bytes.size()));
  const auto& counts = contents->counts;
  for (const std::uint64_t count : {counts.leaves, counts.occupied_leaves, counts.free_leaves,
                                    counts.occupied_voxels, counts.free_voxels}) {
    writer.put(capped(count));
  }
  writer.put(std::uint64_t{0});
  return {};
}

Result<tile_reply_t> TileQueries::answer(const tile_request_t& request) {
  auto key = atlas_.parameters().grid().tile_from_morton(static_cast<std::uint64_t>(request.tile));
  if (!key) return pass_on(key, "tile_request_t");
  tile_reply_t reply{};
  reply.utime = utime_now();
  reply.client = request.client;
  reply.id = request.id;
  reply.tile = request.tile;
  if (request.depth < 0 || request.depth > kDepth) {
    return fail(ErrorCode::kOutOfRange, fmt::format("tile_request_t: depth {}", request.depth));
  }
  if (request.offset < 0) {
    return fail(ErrorCode::kOutOfRange, fmt::format("tile_request_t: offset {}", request.offset));
  }
  auto encoded = encodings_.of(*key, request.depth, request.offset > 0);
  if (!encoded && encoded.error().code == ErrorCode::kNotFound) return reply;  // Version 0.
  if (!encoded) return pass_on(encoded);
  const auto total = encoded->bytes.size();
  // Beyond the end is no error: the tile may have shrunk since the range before, and the asker
  // sees by the version and the offset that it did.
  const auto offset = std::min(static_cast<std::size_t>(request.offset), total);
  reply.version = static_cast<std::int64_t>(encoded->version);
  reply.total = static_cast<std::int32_t>(total);
  reply.offset = static_cast<std::int32_t>(offset);
  const auto payload =
      ByteView(encoded->bytes).subspan(offset, std::min(total - offset, kMaxPayloadBytes));
  reply.payload.assign(payload.begin(), payload.end());
  reply.size = static_cast<std::int32_t>(reply.payload.size());
  if (offset + payload.size() < total) encodings_.keep(std::move(*encoded), request.depth);
  return reply;
}

}  // namespace voxatlas
