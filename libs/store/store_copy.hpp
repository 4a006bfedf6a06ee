#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/sha256.hpp"
#include "store/tile_store.hpp"

namespace voxatlas {

/// What a shard holds, and SHA-256 over all of it: tiles (key, version, bytes), the journal's
/// records, marks and values. Positions in the journal do not count.
struct ShardContent {
  std::uint64_t tiles = 0;  ///< Tombstones included.
  std::uint64_t records = 0;
  std::uint64_t written = 0;  ///< copy_shard: tiles that were not there from an earlier call.
  Sha256Digest digest{};
};

/// Called before each page of tiles with how many are done; its error stops the work.
using CopyProgress = std::function<Status(std::uint64_t tiles)>;

/// Reads a shard. `values`: the names of those that count.
Result<ShardContent> shard_content(TileStore& store, ShardId shard,
                                   const std::vector<std::string>& values,
                                   const CopyProgress& progress);

/// Every tile of a shard, tombstones included, ascending, some at a time.
using VisitPage = std::function<Status(std::vector<StoredTile>&)>;
Status for_each_page(TileStore& store, ShardId shard, const VisitPage& visit);

/// Makes `to`'s shard hold what `from`'s does, journal positions aside, and reads both to compare.
/// Nobody may write to either meanwhile. Begun again after an interruption it writes only what is
/// missing.
/// Errors:  the stores'. kInvalid where `to` has a tile that is newer: it is no copy of `from`.
///          kCorrupt where the two differ in the end.
Result<ShardContent> copy_shard(TileStore& from, TileStore& to, ShardId shard, Epoch epoch,
                                const std::vector<std::string>& values,
                                const CopyProgress& progress);

/// A shard that is being copied to says so, until it is told that all is there: nobody must take it
/// for a model.
Status mark_unfinished(TileStore& store, ShardId shard, Epoch epoch, bool unfinished);
Result<bool> is_unfinished(TileStore& store, ShardId shard);

}  // namespace voxatlas
