#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.hpp"
#include "atlas/journal_record.hpp"
#include "atlas/journal_tail.hpp"
#include "atlas/rested_tiles.hpp"
#include "atlas/tile_cache.hpp"

namespace voxatlas {

/// What an Atlas holds. Its work is told in four files: atlas_recover.cpp (opening, reading back),
/// atlas_commit.cpp (scans in), atlas_flush.cpp (tiles to the store), atlas_read.cpp (tiles out).
struct Atlas::State {
  using Session = std::pair<std::string, std::int64_t>;
  using Marks = std::map<Session, std::int64_t>;
  using Versions = std::map<TileKey, std::uint64_t>;

  State(TileStore& store_of, ShardId shard_of, const ModelParameters& parameters_of,
        const AtlasOptions& options_of)
      : store(store_of),
        shard(shard_of),
        parameters(parameters_of),
        grid(parameters_of.grid()),
        options(options_of) {}

  TileStore& store;
  ShardId shard;
  ModelParameters parameters;
  Grid grid;
  AtlasOptions options;
  Epoch epoch = 0;

  TileCache cache;
  JournalTail journal;
  Marks marks;
  AtlasStats counts;

  /// A write's outcome is not known, or a durable record could not be applied: what is in memory
  /// counts for nothing until recover() has read the store again.
  bool stale = false;
  /// The last record of which a commit has told every change; of those after it `told` has the
  /// versions up to which it has, and changes that a recovery finds beyond these wait in
  /// `unreported` for the next commit. While opening, all count as reported: whoever subscribed
  /// before asks for snapshots anyway.
  JournalPosition reported = std::numeric_limits<JournalPosition>::max();
  Versions told;
  std::vector<TileChange> unreported;

  bool ascending = false;  ///< The order of tiles in which the last commit was applied.

  RestedTiles rested;
  std::optional<TileKey> rest_cursor;  ///< Stored tiles from here on were not looked at yet.

  // atlas_recover.cpp
  Status acquire();
  Status settle();  ///< Recovers where the state is stale.
  Status recover();
  Status redo(JournalPosition position, ByteView bytes, std::set<TileKey>& redone_tiles);
  Result<bool> redo_delta(JournalPosition position, const JournalDelta& delta);
  std::vector<Mark> mark_list() const;

  // atlas_commit.cpp
  std::int64_t mark(const Session& session) const;
  Status commit(std::span<const ShardScan> scans, const Tell& tell);
  Status check_scan(const ShardScan& scan) const;
  Status check_place(const ShardScan& scan, TileKey key) const;
  /// Those that are no duplicates, checked.
  Result<std::vector<const ShardScan*>> fresh_scans(std::span<const ShardScan> scans) const;
  Result<Versions> current_versions(const std::vector<const ShardScan*>& scans);
  Status make_room();
  Result<JournalPosition> append(const std::vector<const ShardScan*>& scans, Versions versions);
  Status apply_all(const std::vector<const ShardScan*>& scans, JournalPosition first,
                   Versions versions, const Tell& tell);
  Status apply(TileKey key, ByteView bytes, JournalPosition position);
  Status read_back(const std::vector<const ShardScan*>& scans, Error error, const Tell& tell);
  void report(const TileChange& change, const Tell& tell);
  void report_rest(const Tell& tell);

  // atlas_flush.cpp
  Status write_oldest(std::size_t max_tiles);
  Status trim();
  Status keep_budget(std::optional<TileKey> keep);
  Status keep_journal();
  Result<std::optional<std::uint64_t>> take_encoded(const EncodedTile& encoded);
  Status put_lossy(const EncodedTile& encoded, CachedTile& tile, TileTree&& tree);
  std::vector<TileInfo> rested_tiles(std::size_t limit);
  void find_rested(std::size_t limit);

  // atlas_read.cpp
  /// The tile, read where it is not in memory; nullptr where never written. Stays until the next
  /// load or write.
  Result<CachedTile*> load(TileKey key);
  Result<TileTree> decode_stored(const StoredTile& stored) const;
  Result<EncodedTile> encoded(TileKey key, int depth);
  Result<std::vector<TileInfo>> list(TileKey from, std::size_t limit);
};

}  // namespace voxatlas
