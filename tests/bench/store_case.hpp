#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "base/result.hpp"

namespace voxatlas::bench {

struct Comparison {
  double ratio = 0;  ///< Median over the slices: our rate over raw RocksDB's.
  double ours_per_s = 0, raw_per_s = 0;
};

Comparison compare_tile_commits(const std::string& directory);
Comparison compare_journal_commits(const std::string& directory);

/// Bytes on disk over live bytes, when every tile has been written 8 times and the store rests.
double space_after_overwriting(const std::string& directory);

/// A child process commits scans until the journal is full, and is killed with -9: simulated ones,
/// or those of a folder in KITTI odometry form, from the first again after the last.
/// Before anything here uses RocksDB: a forked child would lack its threads.
void simulate_and_kill(const std::string& directory);
void drive_and_kill(const std::string& directory, const std::string& data,
                    const std::string& poses);

struct Opening {
  double seconds = 0;  ///< Store and shard together, until tiles can be read.
  double journal_mib = 0, records = 0, tiles = 0;
};
Opening open_after_kill(const std::string& directory);

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace voxatlas::bench
