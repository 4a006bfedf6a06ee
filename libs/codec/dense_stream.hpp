#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// A tile, exact, as few bytes as we know how: from the top down, every bit range-coded with a
/// chance learnt in its context. Layout: FORMAT.md, "dense".
///
/// Limits: at most 65 535 distinct log-odds; can_be_dense() tells. A tile within |L| < 8 always
/// can. Cost:   about 3 us a mixed brick to encode and to decode.
Bytes encode_dense(const TileTree& tree);
bool can_be_dense(const TileTree& tree);

/// The tile cut at `depth`: each cell of that depth that knows anything is the highest log-odds in
/// it, and its colour, where a cell of depth 4 or above holds any, the mean of the coloured voxels;
/// cells cut at depth 5 and 6 take the mean of their brick. 7: the tile itself.
/// Errors: kCorrupt for bytes that no encoder wrote. Memory: bounded by one tile.
Result<TileTree> decode_dense(ByteView bytes, int depth = kDepth);

}  // namespace voxatlas
