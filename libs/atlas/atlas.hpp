#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "base/result.hpp"
#include "grid/grid.hpp"
#include "octree/tile_delta.hpp"
#include "octree/tile_tree.hpp"
#include "store/tile_store.hpp"

namespace voxatlas {

struct AtlasOptions {
  std::size_t cache_bytes = std::size_t{256} << 20;  ///< Budget for tiles in memory.
  std::size_t journal_max_bytes = std::size_t{32}
                                  << 20;  ///< Dirty tiles are flushed to stay below.
  bool keep_journal = false;     ///< Records are never trimmed: all that ever was can be replayed.
  double rest_seconds = 2;       ///< Unchanged for so long after its flush, a tile is rested() ...
  std::size_t rest_bytes = 128;  ///< ... if its stored bytes are at least so many.
};

/// One scan's part for one shard; deltas in the bytes of encode_delta, ascending by key.
struct ShardScan {
  std::string source;
  std::int64_t session = 0;
  std::int64_t seq = 0;
  std::vector<std::pair<TileKey, Bytes>> deltas;
};

/// A change of a tile, for updates: its new version and the delta that led there.
struct TileChange {
  TileKey key;
  std::uint64_t version = 0;
  Bytes delta;  ///< encode_delta's bytes.
};

struct TileInfo {
  TileKey key;
  std::uint64_t version = 0;
};

struct EncodedTile {
  TileKey key;
  std::uint64_t version = 0;
  Bytes bytes;  ///< encode_tile's.
};

struct AtlasStats {
  std::uint64_t cached_tiles = 0, cached_bytes = 0, dirty_tiles = 0;
  std::uint64_t resting_tiles = 0;  ///< Known to be stored by the fast codec: rested() or soon.
  std::uint64_t journal_bytes = 0;  ///< Appended since the last trim.
  std::uint64_t scans_applied = 0, deltas_applied = 0, tiles_flushed = 0, cache_misses = 0;
  /// Of the last recovery: at open, or after a write whose outcome was not known.
  std::uint64_t replayed_records = 0, replayed_bytes = 0, redone_deltas = 0, skipped_deltas = 0;
};

/// One shard's tiles: cache, journal and store together. The paper's Global Index.
///
/// Source:  the paper's section 3.1; DESIGN section 7. A commit appends one journal record a scan,
///          naming each tile, its delta and the version it produces; then applies it in memory.
///          Tiles are flushed at leisure; the journal is trimmed, with the marks, behind the oldest
///          unflushed change. Opening replays: a record is applied where the stored version is one
///          less, skipped where it is as high, otherwise the shard is corrupt.
/// Order:   a source's scans must come in seq order without gaps (ScanOrder sees to it): seq at or
///          below the mark is skipped as a duplicate, a gap is kInvalid.
/// Memory:  tiles within 1.5 x cache_bytes, whatever the model's size.
/// Threads: one at a time.
class Atlas {
 public:
  /// Acquires the shard and recovers it. A fresh shard takes `parameters` as its own.
  /// Errors: kInvalid where the stored parameters differ (naming which), and the store's own.
  static Result<std::unique_ptr<Atlas>> open(TileStore& store, ShardId shard,
                                             const ModelParameters& parameters,
                                             const AtlasOptions& options);
  /// The parameters a shard was made with, if it was; for opening a model as it is.
  /// Errors: the store's; kInvalid for an unfinished copy.
  static Result<std::optional<ModelParameters>> stored_parameters(TileStore& store, ShardId shard);
  /// Names of the store's values that an atlas keeps, for who copies a shard.
  static std::vector<std::string> value_names();
  ~Atlas();

  const ModelParameters& parameters() const;
  ShardId shard() const;
  Epoch epoch() const;

  /// Told of a change, once it is durable and applied. Must not call the atlas.
  using Tell = std::function<void(const TileChange&)>;

  /// All scans with one group commit, durable on return; nothing is applied where it fails.
  /// Tells of every change once, a tile's in the order of its versions: tile by tile as they are
  /// applied, so that who is told can work meanwhile.
  /// Where the store does not know what happened (kUnknown, kIo), the journal is read back: here,
  /// or where that fails too, by the next call. Scans found there count as applied: offering them
  /// again skips them and tells of their changes, but for those that were told already.
  /// Errors: kCorrupt for a delta that does not decode, kOutOfRange for a tile not of this grid or
  ///         shard (refuse such a scan before, by check_scan), and the store's.
  Status commit(
      std::span<const ShardScan> scans, const Tell& tell = [](const TileChange&) {});
  /// What commit would say of this scan alone, without doing it; not of its place in the order,
  /// as its predecessors may still wait.
  Status check_scan(const ShardScan& scan) const;

  /// The last seq applied of a source's session, -1 for none. Sorted by source and session in
  /// marks().
  std::int64_t mark(const std::string& source, std::int64_t session) const;
  std::vector<Mark> marks() const;

  /// A tile and its version; nullptr where never written. Valid until the next call that is not
  /// const or that reads another tile.
  struct Tile {
    const TileTree* tree = nullptr;
    std::uint64_t version = 0;
  };
  Result<Tile> tile(TileKey key);
  /// The tile encoded: stored bytes where they are current, else made with the fast codec. Above
  /// depth 7 the tile cut there (cut_tile), dense, made now. kNotFound where never written.
  Result<EncodedTile> encoded(TileKey key, int depth = kDepth);

  /// Up to `limit` tiles with key >= from, ascending, in memory or on disk; no tombstones.
  Result<std::vector<TileInfo>> list(TileKey from, std::size_t limit);

  /// Takes a compressor's bytes if the version is still the newest. Those that decode to the same
  /// tile keep its version; those of a lossy codec become its next one, durable on return, if each
  /// voxel stays unknown, free or occupied as it was. Returns the version that the tile has now;
  /// nullopt: not taken. Errors: kCorrupt where they do not decode or a voxel changes sides.
  Result<std::optional<std::uint64_t>> take_encoded(const EncodedTile& encoded);

  /// Writes dirty tiles, oldest first, at most `max_tiles`, then trims. flush() writes all.
  Status flush_some(std::size_t max_tiles);
  Status flush();

  /// Another budget for tiles from now on. Clean tiles above it go at once, dirty ones as the next
  /// commits write them.
  void limit_cache(std::size_t bytes);

  /// Tiles that have rested for compressing: flushed by the fast codec, unchanged for a while, not
  /// so small that nothing is to be gained.
  std::vector<TileInfo> rested(std::size_t limit);

  AtlasStats stats() const;

 private:
  struct State;
  explicit Atlas(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
