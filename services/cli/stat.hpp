#pragma once

#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct StatOptions {
  std::string url;
  std::string hashes;  ///< File for one line a tile: key, version, hash. Empty: none.
  bool json = false;
};

/// Prints what the model holds: tiles, cells by state, bytes; parameters.
/// Errors: kUnavailable, kIo for the file.
Status run_stat(const StatOptions& options);

}  // namespace voxatlas
