#pragma once

#include <memory>
#include <string>
#include <vector>

#include "store/tile_store.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas::test {

/// One kind of store under the contract test.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual TileStore& store() = 0;
  virtual void reopen() = 0;  ///< Closes the store and opens what it has left.
  /// Opens a checkpoint that store() made.
  virtual std::unique_ptr<TileStore> open_checkpoint(const std::string& directory) = 0;
  /// A path in a folder of this backend's own.
  std::string path(const std::string& name) const { return folder_ / name; }

 private:
  TempDir folder_;
};

/// A fresh store of every kind there is.
std::vector<std::unique_ptr<Backend>> all_backends();

}  // namespace voxatlas::test
