#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"
#include "store/tile_store.hpp"

namespace voxatlas {

/// A tile in memory. Its tree may be changed by whoever then calls TileCache::changed().
struct CachedTile {
  TileTree tree;
  std::uint64_t version = 0;

  bool dirty() const { return first_change != 0; }
  JournalPosition first_change = 0;  ///< Of the oldest change the store has not; 0: it has all.
  std::size_t bytes = 0;             ///< As counted by the cache.
  std::uint64_t used = 0;            ///< When it was last used, by the cache's own clock.
};

/// Tiles by key, counted in bytes, least recently used first out; dirty ones stay until cleaned().
/// It knows no store: who flushes and reads is the atlas.
///
/// Ownership: a CachedTile* lives until its tile is evicted.
/// Cost:      logarithmic in the number of tiles.
class TileCache {
 public:
  /// nullptr where the tile is not here. find() counts as use, peek() does not.
  CachedTile* find(TileKey key);
  const CachedTile* peek(TileKey key) const;

  /// A tile that is not here yet, clean.
  CachedTile& insert(TileKey key, TileTree tree, std::uint64_t version);
  /// The tile's tree was changed by the record at `position`: one version on, and dirty.
  void changed(TileKey key, JournalPosition position);
  /// The tile was written as it is.
  void cleaned(TileKey key);
  void clear();

  /// Drops clean tiles, the longest unused first, but never `keep`, until at most `budget` bytes
  /// are held. False where dirty tiles (or `keep`) still hold more.
  bool evict(std::size_t budget, std::optional<TileKey> keep);

  /// Up to `limit` dirty tiles, those whose oldest change is oldest first.
  std::vector<TileKey> oldest_dirty(std::size_t limit) const;
  /// Position of the oldest change that the store has not; nullopt where it has all.
  std::optional<JournalPosition> oldest_change() const;

  std::size_t bytes() const { return bytes_; }
  std::size_t tiles() const { return tiles_.size(); }
  std::size_t dirty_tiles() const { return dirty_.size(); }

  /// All tiles, ascending by key.
  const std::map<TileKey, CachedTile>& by_key() const { return tiles_; }

 private:
  void use(TileKey key, CachedTile& tile);
  void recount(CachedTile& tile);

  std::map<TileKey, CachedTile> tiles_;
  std::map<std::uint64_t, TileKey> clean_;  // By last use.
  std::set<std::pair<JournalPosition, TileKey>> dirty_;
  std::size_t bytes_ = 0;
  std::uint64_t clock_ = 0;
};

}  // namespace voxatlas
