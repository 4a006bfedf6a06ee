#pragma once

#include <cstddef>

#include "base/result.hpp"

namespace voxatlas {

/// How the memory of a process that keeps one shard is divided.
///
/// The parts make up the budget; the process stays within 1.5 times the budget, whatever the
/// model's size. The half beside it is for the program itself (20 MiB of code), for what the
/// allocator keeps to hand out again (25 MiB where tiles come and go), and for the one scan that is
/// larger than its part. Units: bytes.
struct MemoryPlan {
  /// Below this what lies beside the budget would be more than half of it.
  static constexpr std::size_t kLeastBudget = std::size_t{128} << 20;

  std::size_t tiles = 0;          ///< AtlasOptions::cache_bytes.
  std::size_t store = 0;          ///< RocksDbOptions::memory_bytes.
  std::size_t write_buffers = 0;  ///< RocksDbOptions::write_buffer_bytes, a part of `store`.
  std::size_t arriving = 0;       ///< Messages on their way in (ConsumerConfig::max_held_bytes).
  std::size_t commit = 0;         ///< Deltas of one commit, in the dozen forms they take in it.

  /// Errors: kOutOfRange below kLeastBudget.
  static Result<MemoryPlan> of(std::size_t budget);
};

}  // namespace voxatlas
