#pragma once

#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "codec/quantize.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// How a tile's bytes were made. The number stands in every encoded tile's header, for ever.
enum class TileCodec : std::uint8_t {
  kFast = 1,   ///< Exact, the store's own writes: voxels of bricks, Zstandard level 1.
  kDense = 2,  ///< Exact, for rest: from the top down, range-coded in context.
  kLossy = 3,  ///< As dense, once `CodecOptions::lossy` has made the tile coarser.
};

struct CodecOptions {
  TileCodec codec = TileCodec::kFast;
  int level = 0;         ///< Zstandard's effort in fast tiles, 1..19; 0: its default.
  Quantization lossy{};  ///< Of lossy tiles; must pass check().
};

/// A tile as bytes. Fast and dense are exact: state, log-odds, colour with its count, depth of
/// every leaf; lossy is quantize(tree, options.lossy), exactly. Layout: FORMAT.md (versioned
/// header, codec, CRC-32C of everything). An empty tile has an encoding too.
///
/// Size: at most 8 bytes for each node of the octree, 4 more for a coloured leaf, and 64. A few
/// large
///       coloured cells that would take more are written as version 1 did, exact and dense; a tile
///       of all 65 536 log-odds, of which -8 is outside |L| < 8, too, as fast.
Bytes encode_tile(const TileTree& tree, const CodecOptions& options);

/// Errors: kCorrupt for any bytes encode_tile (of this or an earlier version) did not write,
/// kInvalid for a newer version. Memory: bounded by one tile, whatever the bytes claim.
Result<TileTree> decode_tile(ByteView bytes);

/// The tile as it is seen from farther away: each cell of `depth` that knows anything is the
/// highest log-odds in it, with a mean colour (cut_tile). Depth 7 is the tile itself.
/// Cost:   shrinks with the depth in dense and lossy tiles (4: a sixth of the whole, and hardly
///         less above: all slots are read); in fast ones at depth 4, below it that of the whole.
/// Errors: as decode_tile; damage is found at any depth.
Result<TileTree> decode_tile_to_depth(ByteView bytes, int depth);

/// What decode_tile_to_depth gives, of a tile at hand. Colour: the mean of a cell's coloured voxels
/// at depth 0..4, of its brick's at 5 and 6 (where the cell is occupied).
TileTree cut_tile(const TileTree& tree, int depth);

/// Reads the header alone. Errors: kCorrupt as decode_tile, but the payload is not looked at.
Result<TileCodec> codec_of(ByteView bytes);

/// How a lossy tile was quantised, from the header alone. Errors: as codec_of; kInvalid if the tile
/// is exact.
Result<Quantization> quantization_of(ByteView bytes);

}  // namespace voxatlas
