#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "render/build_job.hpp"
#include "render/tile_asker.hpp"

namespace voxatlas {

/// Tiles as they are drawn, and what newer versions of them are made from.
///
/// Life:    of a tile that is not here the coarse cells are asked for first, and a coarse tree is
///          built of them; then all of it, and a fine tree. The bytes are kept while there is
///          room. A tile that changes is made of them, or asked for once more, and kept, so that
///          further changes only have to be applied; for kKeepLive after the last of them. Where a
///          listing is ahead of them, they are waited for before all of it is asked for. A tile
///          that comes into being where somebody looks is known from its first change on.
/// Memory:  at most the budget, but for what has been used less than kInUse ago; those used longest
///          ago go first.
/// Time:    is told. Threads: one at a time; trees are shared with whoever draws them.
class TreeCache {
 public:
  static constexpr int kCoarse = 4;                     ///< Depth of a tile's first tree.
  static constexpr std::int64_t kKeepLive = 5'000'000;  ///< Microseconds.
  static constexpr std::int64_t kInUse = 1'000'000;

  explicit TreeCache(std::size_t budget_bytes) : budget_(budget_bytes) {}

  /// Bytes that came from a store. Older ones than what is here are dropped.
  void take(ArrivedTile arrived, std::int64_t now);

  /// A moment of a change: when it became durable, by its store's clock, and when it was told of,
  /// by ours; utime.
  struct Since {
    std::int64_t durable = 0, told = 0;
    friend bool operator==(const Since&, const Since&) = default;
  };
  /// A change that was told of: `content` and payload as in tile_update_t.
  struct Update {
    TileKey key;
    std::uint64_t version = 0;
    int content = 0;
    Bytes payload;
    Since since;
  };
  /// `watched`: somebody looks there, so that a tile that is new is wanted.
  void update(Update update, bool watched, std::int64_t now);

  void take(BuiltTile built, std::int64_t now);

  /// A version that a listing told of. The changes that lead to it may still be on their way.
  void hear(TileKey key, std::uint64_t version, std::int64_t now);

  /// How a tile stands against the newest version known.
  struct Standing {
    std::shared_ptr<const RenderTree> tree;  ///< What can be drawn now; null: nothing.
    std::shared_ptr<const FreeCells> free;   ///< Of the depth asked for; null: not here.
    bool complete = false;      ///< It is fine and as new, or nothing better will come.
    bool fine = false;          ///< The tree is at full depth.
    bool must_ask = false;      ///< The bytes are to be asked for,
    int ask_depth = kDepth;     ///< to this depth.
    bool smooth = false;        ///< Complete, and its normals are of what is around it, too.
    std::int64_t rough_at = 0;  ///< When a tree around it, or its own, last changed.
    std::uint64_t serial = 0;   ///< Of the tree: another one has another.
    bool must_build = false;    ///< job() has something to do.
    Since stale;                ///< Of the first change not shown; 0: none is known.
    /// Since when a listing is ahead of the changes, steady; 0: none is.
    std::int64_t behind_since = 0;
  };
  /// `free_depth`: of the free cells that are drawn too; 0: none are.
  Standing look(TileKey key, std::uint64_t newest, std::int64_t now, int free_depth = 0);

  /// What is to be built of a tile next, nullopt where nothing is or it is being built. Where it is
  /// as new as can be, its normals across borders, if they are asked for.
  std::optional<BuildJob> job(TileKey key, bool borders = true);

  /// Drops tiles until the budget holds or only those in use are left.
  void trim(std::int64_t now);
  bool full() const { return bytes_ - spare_bytes_ >= budget_; }

  std::size_t bytes() const { return bytes_; }
  std::size_t tiles() const { return tiles_.size(); }
  std::size_t broken() const { return broken_; }  ///< Tiles whose bytes or changes were none.

 private:
  struct Tile {
    std::uint64_t reach = 0;  // The version that the changes lead to; without, the source's.
    std::shared_ptr<const Bytes> bytes;  // The source: bytes, spare once a tree shows them,
    std::optional<TileTree> live;        // or the tile, which a job may have borrowed.
    std::size_t live_bytes = 0;
    bool lent = false;
    std::shared_ptr<const Bytes> coarse;  // For the first tree; of a version of its own.
    std::uint64_t coarse_version = 0;
    std::vector<Bytes> changes;  // One a version, up to `reach`; kept without a source too.
    std::shared_ptr<const RenderTree> tree;
    std::shared_ptr<const FreeCells> free;  // As new as the tree, or null.
    int free_wanted = 0;                    // A depth.
    bool fine = false;
    bool building = false;
    bool rough = false;        // Since its normals were made, a tree around it has changed.
    std::uint64_t serial = 0;  // Of the tree.
    bool lives = false;        // It changes: keep it once it is here.
    bool lost_track = false;   // What comes back from the job is of no use for the next.
    std::uint64_t broken = 0;  // This version is no tile: not asked for again.
    Since stale, stale_next;   // The latter: since the job was made.
    std::int64_t used_at = 0, changed_at = 0, ask_again_at = 0, rough_at = 0, behind_since = 0;
    std::size_t counted = 0, spare = 0;  // Its share of bytes_ and of spare_bytes_.

    bool rests() const { return fine && !building && changes.empty() && shown() >= reach; }
    bool has_source() const { return lent || live.has_value() || bytes != nullptr; }
    std::uint64_t shown() const { return tree ? tree->version() : 0; }
    std::uint64_t known() const { return std::max(reach, shown()); }
    void drop_source();
  };

  void count(Tile& tile);
  void settle(Tile& tile, std::int64_t now);
  BuildJob coarse_job(TileKey key, Tile& tile);
  BuildJob border_job(TileKey key, Tile& tile);
  void roughen(TileKey key, std::int64_t now);
  void drop_spare();

  std::size_t budget_;
  std::size_t bytes_ = 0, broken_ = 0;
  std::size_t spare_bytes_ = 0;  ///< Of bytes_, what goes before any tile does.
  std::uint64_t serials_ = 0;
  std::int64_t trimmed_at_ = 0;
  std::unordered_map<TileKey, Tile> tiles_;
};

}  // namespace voxatlas
