#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "base/result.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas {

/// A model's folder being written, by region hash into so many shards. It counts for nothing until
/// finish(), and so is not synced row by row.
class NewModel {
 public:
  /// Errors: kIo and the stores' own. The folder must not exist.
  static Result<NewModel> create(const std::string& directory, const ModelParameters& parameters);

  Status put(const std::vector<StoredTile>& tiles);
  /// Sets every shard's marks, closes, opens again and counts: what was put is there.
  Status finish(const std::vector<Mark>& marks);

  std::uint64_t tiles() const { return tiles_; }

 private:
  struct Shard {
    std::unique_ptr<RocksDbStore> store;
    Epoch epoch = 0;
    std::uint64_t tiles = 0;
  };

  std::string directory_;
  std::vector<Shard> shards_;
  std::uint64_t tiles_ = 0;
};

}  // namespace voxatlas
