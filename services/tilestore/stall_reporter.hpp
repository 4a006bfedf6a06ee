#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "tilestore/watched_store.hpp"

namespace voxatlas {

/// Says in the status that the service waits for its store, while the service itself cannot: twice
/// a second, from a second's waiting on, under the service's own name and instance. It also tells
/// systemd's watchdog that waiting is not hanging.
///
/// Ownership: borrows the store.
/// Threads:   one of its own, with a bus of its own.
class StallReporter {
 public:
  static constexpr std::int64_t kPatience = 1'000'000;  ///< Microseconds.

  /// `instance`: of the service's own StatusPublisher.
  StallReporter(const WatchedStore& store, std::string url, std::int32_t shard,
                std::int64_t instance);
  ~StallReporter();

 private:
  void watch();

  const WatchedStore& store_;
  std::string url_;
  std::int32_t shard_;
  std::int64_t instance_;

  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;  // Guarded by mutex_.
  std::thread thread_;
};

}  // namespace voxatlas
