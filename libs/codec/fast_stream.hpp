#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "codec/dense_colours.hpp"
#include "codec/pyramid.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// A tile, exact, in two parts that are quick to write and to read, before Zstandard: the *head*
/// has what each slot is, the *body* the voxels of mixed bricks. Layout: FORMAT.md, "fast".
struct FastParts {
  Bytes head, body;
};

FastParts encode_fast(const TileTree& tree);

/// Errors: kCorrupt for bytes that no encoder wrote. Memory: bounded by one tile.
Result<TileTree> decode_fast(ByteView head, ByteView body);

/// What the head alone tells: slots and palette, and for each coloured brick what stands for it.
struct FastHead {
  Pyramid pyramid;  ///< Without bricks.
  TileColours colours;
};
Result<FastHead> decode_fast_head(ByteView head);

/// encode_fast never makes a head or a body larger: palette, slots, and 11 bytes a coloured brick;
/// masks, two bytes a voxel, and a mask and seven bytes a voxel of colour.
inline constexpr std::size_t kMaxFastHead = 16 + 2 * 65'536 + kBricks * (1 + 2 + 2 + 11);
inline constexpr std::size_t kMaxFastBody = std::size_t{kBricks} * (64 + 1024 + 64 + 512 * 7);

}  // namespace voxatlas
