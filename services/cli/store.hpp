#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct StoreOptions {
  std::string data_dir;  ///< Or a place in a cluster, for verify, stat and copy.
  std::string target;    ///< checkpoint's, copy's and merge's other one.
  std::string hashes;    ///< stat: file for one line a tile, as `voxatlas stat --hashes` writes it.
  std::uint32_t shards = 0;  ///< reshard's.
  bool json = false;
  /// stat: file for one line a shard and source: shard, seq, session, source.
  std::string marks{};
  std::string url{};  ///< verify, stat, checkpoint: where the services are if they run.
};

/// A model's folder. verify, stat and checkpoint work while its services run, too, on a copy made
/// for them; the others refuse then (kUnavailable).

/// Every checksum, every tile decoded and in its place, every journal record applicable. Changes
/// nothing that the model knows. Errors: kCorrupt, after all shards were looked at.
Status run_store_verify(const StoreOptions& options);
/// Tiles, bytes, journal and marks of each shard.
Status run_store_stat(const StoreOptions& options);
/// A copy that is a model of its own, all shards at one state; files are linked where they can be.
Status run_store_checkpoint(const StoreOptions& options);
/// A copy from one place to another, each a folder or in a cluster, that is a model of its own;
/// both at rest. Interrupted, the same call goes on. Compared by SHA-256 over all that is in it.
/// Errors: kInvalid where the target holds a model already, kCorrupt where the two differ.
Status run_store_copy(const StoreOptions& options);
/// Rewrites all files without what was overwritten.
Status run_store_compact(const StoreOptions& options);
/// The same model with another number of shards. The old one is kept beside it.
Status run_store_reshard(const StoreOptions& options);
/// Adds another model's log-odds. The old one is kept beside the result.
Status run_store_merge(const StoreOptions& options);

}  // namespace voxatlas
