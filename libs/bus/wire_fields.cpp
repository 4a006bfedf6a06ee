// Whether the fields of each message agree with one another.
#include "base/bytes.hpp"
#include "bus/checkpoint_wire.hpp"

namespace voxatlas {
namespace {

Status expect(bool agree, const char* what, std::int64_t first, std::int64_t second) {
  if (agree) return {};
  return fail(ErrorCode::kCorrupt, fmt::format("{}: {} and {}", what, first, second));
}

constexpr std::int32_t kMaxGaps = 64;
constexpr std::int32_t kMaxChunkData = 60'000;
constexpr std::int32_t kMaxTilePayload = 59'000;
constexpr std::int64_t kMaxNumber = std::int64_t{1} << 60;  ///< No stream lives to count so far.
constexpr std::int16_t kMaxParts = 64;
constexpr std::size_t kMaxSourceBytes = 64;

/// The blob of a scan_delta_t: so many records, ascending by key, and nothing after them.
Status check_records(const scan_delta_t& delta) {
  ByteReader reader(delta.data);
  std::uint64_t last = 0;
  for (std::int32_t i = 0; i < delta.tiles; ++i) {
    const auto key = reader.get<std::uint64_t>();
    reader.get_bytes(reader.get<std::uint32_t>());
    if (!reader.ok()) return expect(false, "tile past the end: tile, tiles", i, delta.tiles);
    if (i > 0 && key <= last) {
      return fail(ErrorCode::kCorrupt, fmt::format("tiles not ascending at {}: {:#x}", i, key));
    }
    last = key;
  }
  return expect(reader.at_end(), "bytes after the tiles: tiles, size", delta.tiles, delta.size);
}

}  // namespace

template <>
Status check_fields(const ack_t& ack) {
  if (ack.gaps < 0 || ack.gaps > kMaxGaps || ack.size != 16 * ack.gaps) {
    return expect(false, "gaps and size", ack.gaps, ack.size);
  }
  ByteReader reader(ack.ranges);
  for (std::int32_t i = 0; i < ack.gaps; ++i) {
    const auto first = reader.get<std::int64_t>();
    const auto end = reader.get<std::int64_t>();
    if (auto range = expect(0 <= first && first < end, "gap", first, end); !range) return range;
  }
  if (auto credit = expect(ack.credit >= 0, "credit", ack.credit, 0); !credit) return credit;
  return expect(0 <= ack.committed && ack.committed <= ack.received, "committed and received",
                ack.committed, ack.received);
}

template <>
Status check_fields(const camera_t&) {
  return {};  // Its numbers are the renderer's to judge.
}

template <>
Status check_fields(const chunk_t& chunk) {
  if (chunk.base < 0 || chunk.seq < chunk.base) {
    return expect(false, "base and seq", chunk.base, chunk.seq);
  }
  if (chunk.message < 0 || chunk.message > kMaxNumber || chunk.offered > kMaxNumber) {
    return expect(false, "message and offered", chunk.message, chunk.offered);
  }
  if (chunk.count == 0) {
    if (auto empty = expect(chunk.size == 0, "probe with data", chunk.seq, chunk.size); !empty) {
      return empty;
    }
    return expect(chunk.offered >= chunk.seq, "offered and seq", chunk.offered, chunk.seq);
  }
  if (chunk.index < 0 || chunk.index >= chunk.count) {
    return expect(false, "index and count", chunk.index, chunk.count);
  }
  if (chunk.index > chunk.seq) return expect(false, "index and seq", chunk.index, chunk.seq);
  if (chunk.offered <= chunk.seq) {
    return expect(false, "offered and seq", chunk.offered, chunk.seq);
  }
  return expect(chunk.size <= kMaxChunkData, "size above", chunk.size, kMaxChunkData);
}

template <>
Status check_fields(const counter_t&) {
  return {};
}

template <>
Status check_fields(const frame_t& frame) {
  if (frame.format < 0 || frame.format > 2) return expect(false, "format", frame.format, 2);
  if (frame.depth_format < 0 || frame.depth_format > 2) {
    return expect(false, "depth_format", frame.depth_format, 2);
  }
  if (frame.depth_format == 0 && frame.depth_size != 0) {
    return expect(false, "no depth_format, but depth_size", frame.depth_size, 0);
  }
  return expect(frame.error.empty() || (frame.size == 0 && frame.depth_size == 0),
                "error with a picture: size and depth_size", frame.size, frame.depth_size);
}

template <>
Status check_fields(const checkpoint_reply_t& reply) {
  return expect(reply.shard >= 0 && reply.folder.empty() != reply.error.empty(),
                "shard, or both of folder and error:", reply.shard,
                static_cast<std::int64_t>(reply.folder.size()));
}

template <>
Status check_fields(const checkpoint_request_t& request) {
  return expect(request.shard >= 0 && request.reply_port >= 0, "shard and reply_port",
                request.shard, request.reply_port);
}

template <>
Status check_fields(const model_reply_t& reply) {
  return expect(reply.shard >= 0 && reply.mark >= -1, "shard and mark", reply.shard, reply.mark);
}

template <>
Status check_fields(const model_request_t& request) {
  if (request.claim < 0 || request.claim > 2 || request.acked_below < 0) {
    return expect(false, "claim and acked_below", request.claim, request.acked_below);
  }
  return expect(request.shard >= 0 && request.reply_port >= 0, "shard and reply_port",
                request.shard, request.reply_port);
}

template <>
Status check_fields(const render_request_t&) {
  return {};  // A path that is none is answered: its asker waits for a frame.
}

template <>
Status check_fields(const scan_delta_t& delta) {
  if (delta.shard < 0 || delta.shard >= delta.shards) {
    return expect(false, "shard and shards", delta.shard, delta.shards);
  }
  if (delta.tiles < 0) return expect(false, "tiles", delta.tiles, 0);
  if (delta.source.empty() || delta.source.size() > kMaxSourceBytes) {
    return expect(false, "bytes of source", static_cast<std::int64_t>(delta.source.size()), 64);
  }
  if (delta.session < 0 || delta.seq < 0) {
    return expect(false, "session and seq", delta.session, delta.seq);
  }
  return check_records(delta);
}

template <>
Status check_fields(const scan_t& scan) {
  if (scan.source.empty() || scan.source.size() > kMaxSourceBytes) {
    return expect(false, "bytes of source", static_cast<std::int64_t>(scan.source.size()), 64);
  }
  if (scan.session < 0 || scan.seq < 0) {
    return expect(false, "session and seq", scan.session, scan.seq);
  }
  if (scan.parts < 1 || scan.parts > kMaxParts || scan.part < 0 || scan.part >= scan.parts) {
    return expect(false, "part and parts", scan.part, scan.parts);
  }
  if (scan.coloured != 0 && scan.coloured != 1) {
    return expect(false, "coloured", scan.coloured, 0);
  }
  const std::int64_t bytes_a_point = scan.coloured != 0 ? 15 : 12;
  return expect(scan.count >= 0 && scan.size == bytes_a_point * scan.count, "count and size",
                scan.count, scan.size);
}

template <>
Status check_fields(const status_t&) {
  return {};
}

template <>
Status check_fields(const tile_encoded_t& tile) {
  return expect(tile.version >= 0, "version", tile.version, 0);
}

template <>
Status check_fields(const tile_raw_t& tile) {
  if (tile.version < 0 || tile.shard < 0) {
    return expect(false, "version and shard", tile.version, tile.shard);
  }
  return expect(tile.clamp_min < 0 && tile.clamp_max >= 0, "clamps", tile.clamp_min,
                tile.clamp_max);
}

template <>
Status check_fields(const tile_reply_t& reply) {
  if (reply.version < 0) return expect(false, "version", reply.version, 0);
  if (reply.offset < 0 || reply.offset > reply.total) {
    return expect(false, "offset and total", reply.offset, reply.total);
  }
  return expect(reply.size <= kMaxTilePayload && reply.size <= reply.total - reply.offset,
                "size and total", reply.size, reply.total);
}

template <>
Status check_fields(const tile_request_t& request) {
  if (request.shard < 0 || request.reply_port < 0) {
    return expect(false, "shard and reply_port", request.shard, request.reply_port);
  }
  if (request.depth < 0 || request.depth > 7) return expect(false, "depth", request.depth, 7);
  return expect(request.offset >= 0, "offset", request.offset, 0);
}

template <>
Status check_fields(const tile_update_t& update) {
  if (update.content < 0 || update.content > 2) return expect(false, "content", update.content, 2);
  if (update.version < 0) return expect(false, "version", update.version, 0);
  return expect(update.content != 0 || update.size == 0, "content and size", update.content,
                update.size);
}

template <>
Status check_fields(const tiles_reply_t& reply) {
  if (reply.details != 0 && reply.details != 1) return expect(false, "details", reply.details, 1);
  if (reply.next < -1) return expect(false, "next", reply.next, -1);
  const std::int64_t bytes_a_row = reply.details != 0 ? 80 : 16;
  return expect(reply.tiles >= 0 && reply.size == bytes_a_row * reply.tiles, "tiles and size",
                reply.tiles, reply.size);
}

template <>
Status check_fields(const tiles_request_t& request) {
  if (request.shard < 0 || request.reply_port < 0) {
    return expect(false, "shard and reply_port", request.shard, request.reply_port);
  }
  if (request.from < 0) return expect(false, "from", request.from, 0);
  return expect(request.details == 0 || request.details == 1, "details", request.details, 1);
}

}  // namespace voxatlas
