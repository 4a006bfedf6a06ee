#pragma once

#include <compare>
#include <cstdint>

#include "grid/tile_key.hpp"

namespace voxatlas {

/// 4x4x4 tiles (51.2 m at 10 cm), the unit of sharding: the tile's Morton code without its low 6
/// bits.
struct RegionKey {
  std::uint64_t code = 0;

  static RegionKey of(TileKey tile) { return {tile.morton() >> 6}; }

  friend auto operator<=>(RegionKey, RegionKey) = default;
};

/// The shard that owns a region: splitmix64(region code) mod shards. `shards` >= 1.
std::uint32_t shard_of(RegionKey region, std::uint32_t shards);
inline std::uint32_t shard_of(TileKey tile, std::uint32_t shards) {
  return shard_of(RegionKey::of(tile), shards);
}

/// Steele, Lea and Flood's mixing function: every bit of the input reaches every bit of the output.
std::uint64_t splitmix64(std::uint64_t x);

}  // namespace voxatlas
