#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "atlas/atlas.hpp"
#include "base/result.hpp"
#include "octree/tile_hash.hpp"

namespace voxatlas {

/// What is in tiles, in figures. Counting and hashing a tile takes as long as decoding it, so the
/// figures are kept for as long as the tile stays at its version.
///
/// Threads: one at a time.
/// Memory:  at most kMostKept tiles' figures, about 2 MB.
class TileContents {
 public:
  static constexpr std::size_t kMostKept = 16'384;

  struct Figures {
    std::uint64_t version = 0;
    Sha256Digest hash{};
    TileTree::Counts counts;
  };

  explicit TileContents(Atlas& atlas) : atlas_(atlas) {}

  /// `tile`: as the atlas lists it now. Errors: the atlas's own.
  Result<Figures> of(const TileInfo& tile);

 private:
  Atlas& atlas_;
  std::unordered_map<TileKey, Figures> kept_;
};

}  // namespace voxatlas
