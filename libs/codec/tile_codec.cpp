#include "codec/tile_codec.hpp"

#include <fmt/format.h>

#include "base/check.hpp"
#include "base/crc32c.hpp"
#include "codec/node_stream.hpp"
#include "codec/zstd_frame.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kMagic = 0x4c545856;  // "VXTL".
constexpr std::uint8_t kVersion = 1;
constexpr int kFastLevel = 1;
constexpr int kDenseLevel = 12;

struct Header {
  TileCodec codec = TileCodec::kFast;
  std::uint32_t node_bytes = 0;
  std::uint32_t checksum = 0;  ///< Of the header before it and of what follows it.
};

constexpr std::size_t kChecksumAt = 10;
constexpr std::size_t kHeaderBytes = kChecksumAt + 4;

std::uint32_t checksum_of(ByteView tile) {
  return crc32c(tile.subspan(kHeaderBytes), crc32c(tile.first(kChecksumAt)));
}

Result<Header> read_header(ByteView bytes) {
  ByteReader in(bytes);
  const auto magic = in.get<std::uint32_t>();
  const auto version = in.get<std::uint8_t>();
  const auto codec = in.get<std::uint8_t>();
  Header header;
  header.node_bytes = in.get<std::uint32_t>();
  header.checksum = in.get<std::uint32_t>();
  if (!in.ok() || magic != kMagic) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} bytes do not begin like an encoded tile", bytes.size()));
  }
  if (version > kVersion) {
    return fail(ErrorCode::kInvalid,
                fmt::format("tile of version {}: this program knows 1 to {}", version, kVersion));
  }
  if (version == 0 || codec < 1 || codec > 2 || header.node_bytes > kMaxNodeBytes) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile of version {}, codec {} and {} bytes: there is no such", version,
                            codec, header.node_bytes));
  }
  header.codec = static_cast<TileCodec>(codec);
  return header;
}

int level_of(const CodecOptions& options) {
  if (options.level != 0) return options.level;
  return options.codec == TileCodec::kDense ? kDenseLevel : kFastLevel;
}

}  // namespace

Bytes encode_tile(const TileTree& tree, const CodecOptions& options) {
  VOX_CHECK(options.level >= 0 && options.level <= 19);
  const Bytes nodes = encode_nodes(tree);
  VOX_CHECK(nodes.size() <= kMaxNodeBytes);
  Bytes tile;
  ByteWriter out(tile);
  out.put(kMagic);
  out.put(kVersion);
  out.put(static_cast<std::uint8_t>(options.codec));
  out.put(static_cast<std::uint32_t>(nodes.size()));
  out.put(std::uint32_t{0});
  zstd_compress(nodes, level_of(options), tile);
  const std::uint32_t checksum = checksum_of(tile);
  std::memcpy(tile.data() + kChecksumAt, &checksum, sizeof checksum);
  return tile;
}

Result<TileTree> decode_tile(ByteView bytes) {
  auto header = read_header(bytes);
  if (!header) return pass_on(header);
  if (header->checksum != checksum_of(bytes)) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile of {} bytes: its checksum is wrong", bytes.size()));
  }
  auto nodes = zstd_decompress(bytes.subspan(kHeaderBytes), header->node_bytes);
  if (!nodes) return pass_on(nodes, "tile");
  return decode_nodes(*nodes);
}

Result<TileCodec> codec_of(ByteView bytes) {
  auto header = read_header(bytes);
  if (!header) return pass_on(header);
  return header->codec;
}

}  // namespace voxatlas
