#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "store/tile_store.hpp"

namespace voxatlas {

/// Appends of one shard that arrive while one is being written: the first to find nobody writing
/// writes for all who have queued up by then.
///
/// Threads: append() from any thread.
class AppendQueue {
 public:
  struct Appending {
    Epoch epoch;
    std::span<const Bytes> records;
    Result<JournalPosition> result = JournalPosition{0};
    bool done = false;
  };
  /// Writes the records of a group and sets everyone's result. One call at a time.
  using Write = std::function<void(std::span<Appending* const>)>;

  Result<JournalPosition> append(Epoch epoch, std::span<const Bytes> records, const Write& write);

 private:
  std::mutex mutex_;
  std::condition_variable moved_;
  std::vector<Appending*> queue_;  // Guarded by mutex_, as what follows.
  bool writing_ = false;
};

}  // namespace voxatlas
