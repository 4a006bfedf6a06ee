#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/atlas.hpp"
#include "atlas/model_parameters.hpp"
#include "base/result.hpp"
#include "store/store_location.hpp"

namespace voxatlas {

/// A model at rest: the folder, or the place in a cluster, of a set of services that does not run,
/// all its shards open and owned.
///
/// Errors: open: kNotFound where there is no model or a shard of it is missing, kUnavailable where
///         a service has it open (stop the set first), kInvalid where the shards contradict each
///         other, kCorrupt.
class ModelFolder {
 public:
  /// `place` as StoreLocation::parse takes it.
  static Result<ModelFolder> open(const std::string& place);

  const ModelParameters& parameters() const { return parameters_; }
  ShardId shards() const { return parameters_.shards; }
  TileStore& store(ShardId shard) { return *stores_[shard]; }

  /// A shard as its service would open it: recovered from its journal.
  Result<std::unique_ptr<Atlas>> atlas(ShardId shard);
  /// Redoes and empties every journal: what the model knows is then in its tiles alone.
  Status settle();
  /// Every stored tile of a shard, tombstones included, ascending, some at a time.
  using VisitTiles = std::function<Status(std::vector<StoredTile>&)>;
  Status for_each_page(ShardId shard, const VisitTiles& visit);
  /// The marks, which all shards share. Errors: kInvalid where they do not: scans are on their way.
  Result<std::vector<Mark>> common_marks();
  Result<std::optional<StoredTile>> get(TileKey key);

 private:
  ModelParameters parameters_;
  std::vector<std::unique_ptr<TileStore>> stores_;
};

}  // namespace voxatlas
