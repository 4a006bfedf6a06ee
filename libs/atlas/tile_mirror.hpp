#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/tile_key.hpp"
#include "octree/log_odds.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// Tiles whose index (tiles from the index cube's lower corner) lies within, both ends included.
struct TileBox {
  Index3 min{0, 0, 0};
  Index3 max{UINT32_MAX, UINT32_MAX, UINT32_MAX};

  bool holds(TileKey tile) const;
};

/// A copy of what tile stores know, kept up to date by messages that may be lost: a subscriber's
/// side, without a network. Says which tiles must be fetched; whoever uses it fetches them.
///
/// Source:  DESIGN section 6, late joiner: buffer updates, take the snapshot, drop what is not
///          newer, apply the rest; a version gap asks for the tile again.
/// Depth:   at depth 7 a delta that follows the version at hand is applied. Above, tiles are kept
///          as they are seen from farther away (cut_tile), deltas cannot be applied to them, and
///          each change means fetching again.
/// Errors:  on_tile: decode_tile's; the tile stays behind. A delta that does not decode counts as
///          a change without one.
/// Memory:  the tiles within the box, and at most kMostWaiting deltas a tile that is behind.
/// Threads: one at a time.
class TileMirror {
 public:
  static constexpr std::size_t kMostWaiting = 64;

  /// `depth` is 0..7.
  TileMirror(const TileBox& box, int depth, const SensorModel& model);

  /// A tile has got a new version; the delta that led there from version - 1, where it is known.
  void on_change(TileKey tile, std::uint64_t version, std::optional<ByteView> delta);
  /// The store has the tile in this version, as a list says.
  void on_listed(TileKey tile, std::uint64_t version);
  /// A tile that was asked for, in encode_tile's bytes.
  Status on_tile(TileKey tile, std::uint64_t version, ByteView encoded);

  /// The tiles that are behind, those that have been longest first.
  std::vector<TileKey> to_fetch(std::size_t limit) const;
  std::size_t behind() const { return behind_.size(); }

  std::size_t tiles() const { return tiles_.size(); }  ///< With those that are behind.
  using Visit = std::function<void(TileKey, std::uint64_t version, const TileTree&)>;
  /// Every tile of which a version is at hand, ascending by key.
  void for_each(const Visit& visit) const;

  struct Counters {
    std::uint64_t changes = 0;   ///< Heard of, within the box, that were news.
    std::uint64_t applied = 0;   ///< Deltas.
    std::uint64_t gaps = 0;      ///< Times a tile fell behind.
    std::uint64_t fetched = 0;   ///< Tiles that came.
    std::uint64_t unusable = 0;  ///< Deltas and tiles that did not decode.
  };
  const Counters& counters() const { return counters_; }

 private:
  struct Tile {
    TileTree tree;
    std::uint64_t version = 0;               ///< Of the tree.
    std::uint64_t newest = 0;                ///< Heard of.
    std::uint64_t behind_since = 0;          ///< Its place in behind_; 0: it is not there.
    std::map<std::uint64_t, Bytes> waiting;  ///< Deltas by the version they lead to.
  };
  bool apply(Tile& tile, std::uint64_t version, ByteView delta);
  void apply_waiting(Tile& tile);
  void settle(TileKey key, Tile& tile);

  TileBox box_;
  int depth_;
  SensorModel model_;
  std::map<TileKey, Tile> tiles_;
  std::map<std::uint64_t, TileKey> behind_;  ///< By when they fell behind.
  std::uint64_t falls_ = 0;
  Counters counters_;
};

}  // namespace voxatlas
