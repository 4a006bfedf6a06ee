#pragma once

#include <memory>
#include <string>

#include "store/rados_store.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas {

/// Where a model lies: in a folder, embedded, or in a Ceph cluster.
struct StoreLocation {
  std::string folder;    ///< Of an embedded model; empty where it lies in a cluster.
  RadosOptions cluster;  ///< Where `folder` is empty.

  /// "rados:CONF,POOL[,MODEL[,CLIENT]]" is a model in a cluster, any other text a folder.
  /// Errors: kInvalid, also for "".
  static Result<StoreLocation> parse(const std::string& text);

  bool embedded() const { return !folder.empty(); }
  std::string text() const;  ///< What parse() makes the same of.
};

/// One shard's store: of a folder its own folder in there, shard-N; of a cluster all of the model.
/// `options` are for an embedded one.
/// Errors:  those of RocksDbStore::open and RadosStore::open. kUnavailable where the part of the
///          program that speaks to a cluster, or librados, is not installed.
Result<std::unique_ptr<TileStore>> open_store(const StoreLocation& location, ShardId shard,
                                              const RocksDbOptions& options = {});

/// The folder of a shard in a model's folder.
std::string shard_folder(const std::string& directory, ShardId shard);

}  // namespace voxatlas
