#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

/// What stands before an encoded tile's payload. FORMAT.md, "header".
struct TileHeader {
  int version = 0;
  TileCodec codec = TileCodec::kFast;
  std::uint32_t node_bytes = 0;  ///< Version 1: the node stream's, unfolded.
  ByteView payload;              ///< Lies in the bytes that were read.
  bool checksum_holds = false;
};

/// Errors: kCorrupt, or kInvalid for a newer version. A wrong checksum is none yet.
Result<TileHeader> read_tile_header(ByteView tile);

/// A tile of the newest version around a payload.
Bytes seal_tile(TileCodec codec, ByteView payload);
/// The same of version 1, around a Zstandard frame of a node stream.
Bytes seal_tile_v1(TileCodec codec, std::uint32_t node_bytes, ByteView frame);

}  // namespace voxatlas
