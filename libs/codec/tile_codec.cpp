#include "codec/tile_codec.hpp"

#include <fmt/format.h>

#include "base/check.hpp"
#include "codec/dense_colours.hpp"
#include "codec/dense_stream.hpp"
#include "codec/fast_stream.hpp"
#include "codec/node_stream.hpp"
#include "codec/tile_header.hpp"
#include "codec/zstd_frame.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

constexpr int kFastLevel = 1;

Bytes fast_payload(const TileTree& tree, int level) {
  const auto parts = encode_fast(tree);
  VOX_CHECK(parts.head.size() <= kMaxFastHead && parts.body.size() <= kMaxFastBody);
  Bytes payload;
  ByteWriter out(payload);
  Bytes head;
  zstd_compress(parts.head, level, head);
  out.put_varint(parts.head.size());
  out.put_varint(parts.body.size());
  out.put_varint(head.size());
  out.put_bytes(head);
  zstd_compress(parts.body, level, payload);
  return payload;
}

/// A fast payload's two frames, and what they unfold to.
struct FastFrames {
  std::size_t head_bytes = 0, body_bytes = 0;
  ByteView head, body;
};

Result<FastFrames> read_frames(ByteView payload) {
  ByteReader in(payload);
  FastFrames frames;
  const auto head = in.get_varint();
  const auto body = in.get_varint();
  frames.head = in.get_bytes(in.get_varint());
  frames.body = in.get_bytes(in.remaining());
  if (!in.ok() || head > kMaxFastHead || body > kMaxFastBody) {
    return fail(ErrorCode::kCorrupt, fmt::format("tile: a head of {} and a body of {} bytes in {}",
                                                 head, body, payload.size()));
  }
  frames.head_bytes = head;
  frames.body_bytes = body;
  return frames;
}

Result<TileTree> decode_fast_tile(ByteView payload) {
  auto frames = read_frames(payload);
  if (!frames) return pass_on(frames);
  auto head = zstd_decompress(frames->head, frames->head_bytes);
  if (!head) return pass_on(head, "tile, head");
  auto body = zstd_decompress(frames->body, frames->body_bytes);
  if (!body) return pass_on(body, "tile, body");
  return decode_fast(*head, *body);
}

/// What version 1 wrote, for tiles that later codecs do not hold, or not in few enough bytes.
Bytes encode_nodes_tile(const TileTree& tree, TileCodec codec, int level) {
  const Bytes nodes = encode_nodes(tree);
  VOX_CHECK(nodes.size() <= kMaxNodeBytes);
  Bytes frame;
  zstd_compress(nodes, level, frame);
  return seal_tile_v1(codec, static_cast<std::uint32_t>(nodes.size()), frame);
}

/// More than the paper's raw nodes (8 bytes each; an exact colour has 4 bytes more than theirs) and
/// 64 bytes? Only so for a few large cells, which are many bricks: a colour each, in dense bytes.
bool is_too_large(const Bytes& bytes, const TileTree& tree) {
  constexpr std::size_t kAlwaysFits = 72, kNeverFew = 1024;
  if (bytes.size() <= kAlwaysFits || bytes.size() > kNeverFew) return false;
  const auto counts = tree.counts();
  return bytes.size() > 8 * (counts.leaves + counts.inner) + 4 * counts.coloured_leaves + 64;
}

TileTree cut(const Pyramid& pyramid, const TileColours& colours, int depth) {
  BrickTable table = bricks_of(pyramid, depth);
  paint(colours, depth, table);
  return TileTree::of_bricks(std::move(table));
}

Result<TileTree> decode_fast_tile_to_depth(ByteView payload, int depth) {
  auto frames = read_frames(payload);
  if (!frames) return pass_on(frames);
  auto bytes = zstd_decompress(frames->head, frames->head_bytes);
  if (!bytes) return pass_on(bytes, "tile, head");
  auto head = decode_fast_head(*bytes);
  if (!head) return pass_on(head);
  return cut(head->pyramid, head->colours, depth);
}

/// What a lossy payload begins with.
constexpr std::size_t kQuantizationBytes = 6;

void put_quantization(const Quantization& how, ByteWriter& out) {
  out.put(static_cast<std::uint8_t>(how.bits));
  out.put(static_cast<std::uint8_t>(how.colour_bits));
  out.put(how.clamp_min);
  out.put(how.clamp_max);
}

Result<Quantization> get_quantization(ByteView payload) {
  ByteReader in(payload);
  Quantization how;
  how.bits = in.get<std::uint8_t>();
  how.colour_bits = in.get<std::uint8_t>();
  how.clamp_min = in.get<LogOdds>();
  how.clamp_max = in.get<LogOdds>();
  if (!in.ok()) return fail(ErrorCode::kCorrupt, "tile: too short for how it was quantised");
  if (auto ok = how.check(); !ok) return fail(ErrorCode::kCorrupt, "tile: " + ok.error().message);
  return how;
}

Bytes payload_of(const TileTree& tree, const CodecOptions& options, int level) {
  if (options.codec == TileCodec::kFast) return fast_payload(tree, level);
  if (options.codec == TileCodec::kDense) return encode_dense(tree);
  Bytes payload;
  ByteWriter out(payload);
  put_quantization(options.lossy, out);
  out.put_bytes(encode_dense(quantize(tree, options.lossy)));
  return payload;
}

/// The header of a tile whose checksum holds.
Result<TileHeader> read_whole(ByteView bytes) {
  auto header = read_tile_header(bytes);
  if (header && !header->checksum_holds) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile of {} bytes: its checksum is wrong", bytes.size()));
  }
  return header;
}

Result<TileTree> decode_nodes_tile(const TileHeader& header) {
  auto nodes = zstd_decompress(header.payload, header.node_bytes);
  if (!nodes) return pass_on(nodes, "tile");
  return decode_nodes(*nodes);
}

Result<TileTree> decode_dense_tile(const TileHeader& header, int depth) {
  if (header.codec == TileCodec::kDense) return decode_dense(header.payload, depth);
  auto how = get_quantization(header.payload);
  if (!how) return pass_on(how);
  return decode_dense(header.payload.subspan(kQuantizationBytes), depth);
}

Result<TileTree> decode_whole(const TileHeader& header) {
  if (header.version == 1) return decode_nodes_tile(header);
  if (header.codec == TileCodec::kFast) return decode_fast_tile(header.payload);
  return decode_dense_tile(header, kDepth);
}

}  // namespace

Bytes encode_tile(const TileTree& tree, const CodecOptions& options) {
  VOX_CHECK(options.level >= 0 && options.level <= 19);
  const int level = options.level == 0 ? kFastLevel : options.level;
  if (!can_be_dense(tree)) return encode_nodes_tile(tree, TileCodec::kFast, level);
  const Bytes bytes = seal_tile(options.codec, payload_of(tree, options, level));
  if (!is_too_large(bytes, tree)) return bytes;
  const bool fast = options.codec == TileCodec::kFast;
  return encode_nodes_tile(tree, fast ? TileCodec::kFast : TileCodec::kDense, level);
}

Result<TileTree> decode_tile(ByteView bytes) {
  auto header = read_whole(bytes);
  if (!header) return pass_on(header);
  return decode_whole(*header);
}

Result<TileTree> decode_tile_to_depth(ByteView bytes, int depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  auto header = read_whole(bytes);
  if (!header) return pass_on(header);
  const bool fast = header->codec == TileCodec::kFast;
  if (header->version > 1 && !fast) return decode_dense_tile(*header, depth);
  if (header->version > 1 && depth <= kBrickDepth) {
    return decode_fast_tile_to_depth(header->payload, depth);
  }
  auto tree = decode_whole(*header);
  if (!tree) return tree;
  return cut_tile(*tree, depth);
}

TileTree cut_tile(const TileTree& tree, int depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  if (depth == kDepth || tree.empty()) return tree;
  if (!can_be_dense(tree)) {
    TileTree result;
    tree.for_each_cell(depth, [&](const Leaf& leaf) {
      const bool occupied = is_occupied(leaf.state.log_odds);
      result.set(leaf.cell, {leaf.state.log_odds, occupied ? leaf.state.colour : Colour{}});
    });
    return result;
  }
  return cut(pyramid_of(*tree.bricks()), colours_of(*tree.bricks()), depth);
}

Result<TileCodec> codec_of(ByteView bytes) {
  auto header = read_tile_header(bytes);
  if (!header) return pass_on(header);
  return header->codec;
}

Result<Quantization> quantization_of(ByteView bytes) {
  auto header = read_tile_header(bytes);
  if (!header) return pass_on(header);
  if (header->codec != TileCodec::kLossy) return fail(ErrorCode::kInvalid, "the tile is exact");
  return get_quantization(header->payload);
}

}  // namespace voxatlas
