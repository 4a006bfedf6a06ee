#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "atlas/atlas.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas::test {

inline TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }

inline Bytes delta_bytes(const TileDelta& delta) {
  Bytes bytes;
  encode_delta(delta, bytes);
  return bytes;
}

/// Oracle of an atlas: what a shard should know, with no cache, no journal and no store.
class World {
 public:
  struct Tile {
    TileTree tree;
    std::uint64_t version = 0;
  };

  World(std::uint64_t seed, std::uint32_t tile_count) : random(seed), tile_count_(tile_count) {}

  /// A source's next scan: few or many tiles, some changed by nothing, some scans empty. It does
  /// not count until add().
  ShardScan next_scan(const std::string& source, std::int64_t session, std::int64_t ahead = 0);
  /// The scan happened. Returns the changes it makes.
  std::vector<TileChange> add(const ShardScan& scan);

  std::int64_t mark(const std::string& source, std::int64_t session) const;
  /// Everything the atlas knows against everything this knows; the first difference in words,
  /// empty where there is none.
  std::string difference(Atlas& atlas) const;

  std::map<TileKey, Tile> tiles;
  RandomOctree random;

 private:
  TileDelta delta();

  std::uint32_t tile_count_;
  std::map<std::pair<std::string, std::int64_t>, std::int64_t> marks_;
};

/// Commits, and returns all that the atlas told of meanwhile.
Result<std::vector<TileChange>> changes_of(Atlas& atlas, std::span<const ShardScan> scans);

/// Whether these are the same changes, each tile's in the same order.
bool same(std::vector<TileChange> a, std::vector<TileChange> b);

}  // namespace voxatlas::test
