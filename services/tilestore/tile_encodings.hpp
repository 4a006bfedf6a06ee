#pragma once

#include <cstddef>
#include <list>

#include "atlas/atlas.hpp"
#include "base/result.hpp"

namespace voxatlas {

/// Encoded tiles that are being handed out in ranges: each is made once for all its ranges, and all
/// of them are of one version.
///
/// Threads: one at a time.
/// Memory:  kMostBytes, and one tile.
class TileEncodings {
 public:
  /// The sixteenth that MemoryPlan leaves of its least budget.
  static constexpr std::size_t kMostBytes = 8 << 20;

  explicit TileEncodings(Atlas& atlas) : atlas_(atlas) {}

  /// The tile at `depth`. `goes_on`: a range after the first one: what was kept serves, newest or
  /// not. Errors: the atlas's own.
  Result<EncodedTile> of(TileKey key, int depth, bool goes_on);

  /// For the ranges that are still to come. The oldest ones go where there are too many.
  void keep(EncodedTile encoded, int depth);

 private:
  struct Kept {
    EncodedTile encoded;
    int depth;
  };
  std::list<Kept>::iterator find(TileKey key, int depth);

  Atlas& atlas_;
  std::list<Kept> kept_;  ///< The oldest first.
  std::size_t bytes_ = 0;
};

}  // namespace voxatlas
