#pragma once

#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// How a tile's bytes were made. The number stands in every encoded tile's header, for ever.
enum class TileCodec : std::uint8_t {
  kFast = 1,   ///< The store's own writes: the leaf-bit node stream, Zstandard level 1.
  kDense = 2,  ///< For rest: the same stream, Zstandard at a high level.
};

struct CodecOptions {
  TileCodec codec = TileCodec::kFast;
  int level = 0;  ///< Zstandard's effort, 1..19; 0: the codec's own default.
};

/// A tile as bytes, exact: state, log-odds, colour with its count, depth of every leaf. Layout:
/// FORMAT.md (versioned header, codec, CRC-32C of everything). An empty tile has an encoding too.
Bytes encode_tile(const TileTree& tree, const CodecOptions& options);

/// Errors: kCorrupt for any bytes encode_tile (of this or an earlier version) did not write,
/// kInvalid
///         for a newer version. Memory: bounded by one tile, whatever the bytes claim.
Result<TileTree> decode_tile(ByteView bytes);

/// Reads the header alone. Errors: kCorrupt as decode_tile, but the payload is not looked at.
Result<TileCodec> codec_of(ByteView bytes);

}  // namespace voxatlas
