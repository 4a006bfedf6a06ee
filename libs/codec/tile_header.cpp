#include "codec/tile_header.hpp"

#include <fmt/format.h>

#include "base/crc32c.hpp"
#include "codec/node_stream.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kMagic = 0x4c545856;  // "VXTL".
constexpr int kNewest = 2;

/// Where the checksum stands, of what is before it and behind it.
constexpr std::size_t checksum_at(int version) { return version == 1 ? 10 : 6; }

std::uint32_t checksum_of(ByteView tile, std::size_t at) {
  return crc32c(tile.subspan(at + 4), crc32c(tile.first(at)));
}

bool is_codec(int version, unsigned codec) {
  return codec >= 1 && codec <= (version == 1 ? 2u : 3u);
}

}  // namespace

Result<TileHeader> read_tile_header(ByteView tile) {
  ByteReader in(tile);
  const auto magic = in.get<std::uint32_t>();
  TileHeader header;
  header.version = in.get<std::uint8_t>();
  const unsigned codec = in.get<std::uint8_t>();
  if (!in.ok() || magic != kMagic) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} bytes do not begin like an encoded tile", tile.size()));
  }
  if (header.version > kNewest) {
    return fail(ErrorCode::kInvalid, fmt::format("tile of version {}: this program knows 1 to {}",
                                                 header.version, kNewest));
  }
  if (header.version == 1) header.node_bytes = in.get<std::uint32_t>();
  const auto checksum = in.get<std::uint32_t>();
  if (!in.ok() || header.version < 1 || !is_codec(header.version, codec) ||
      header.node_bytes > kMaxNodeBytes) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile of {} bytes, version {}, codec {}, {} unfolded: there is no such",
                            tile.size(), header.version, codec, header.node_bytes));
  }
  header.codec = static_cast<TileCodec>(codec);
  header.payload = tile.subspan(in.position());
  header.checksum_holds = checksum == checksum_of(tile, checksum_at(header.version));
  return header;
}

/// `middle`: what a version has between codec and checksum.
static Bytes seal(int version, TileCodec codec, ByteView middle, ByteView payload) {
  Bytes tile;
  tile.reserve(payload.size() + 14);
  ByteWriter out(tile);
  out.put(kMagic);
  out.put(static_cast<std::uint8_t>(version));
  out.put(static_cast<std::uint8_t>(codec));
  out.put_bytes(middle);
  out.put(std::uint32_t{0});
  out.put_bytes(payload);
  const std::size_t at = checksum_at(version);
  const std::uint32_t checksum = checksum_of(tile, at);
  std::memcpy(tile.data() + at, &checksum, sizeof checksum);
  return tile;
}

Bytes seal_tile(TileCodec codec, ByteView payload) { return seal(kNewest, codec, {}, payload); }

Bytes seal_tile_v1(TileCodec codec, std::uint32_t node_bytes, ByteView frame) {
  Bytes middle;
  ByteWriter(middle).put(node_bytes);
  return seal(1, codec, middle, frame);
}

}  // namespace voxatlas
