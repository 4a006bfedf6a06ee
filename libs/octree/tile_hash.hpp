#pragma once

#include "base/sha256.hpp"
#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// SHA-256 of a tile's key (8 bytes) and its canonical leaves in Morton order: depth, log-odds,
/// colour mean and count. Not of version or stored bytes: equal hashes mean equal knowledge.
/// Exact layout in FORMAT.md beside this file.
Sha256Digest tile_hash(TileKey key, const TileTree& tree);

}  // namespace voxatlas
