#include "store/append_queue.hpp"

#include <utility>

namespace voxatlas {

Result<JournalPosition> AppendQueue::append(Epoch epoch, std::span<const Bytes> records,
                                            const Write& write) {
  Appending mine{epoch, records};
  std::unique_lock lock(mutex_);
  queue_.push_back(&mine);
  moved_.wait(lock, [&] { return mine.done || !writing_; });
  if (mine.done) return mine.result;
  writing_ = true;
  const auto group = std::exchange(queue_, {});
  lock.unlock();
  write(group);
  lock.lock();
  for (auto* member : group) member->done = true;
  writing_ = false;
  moved_.notify_all();
  return mine.result;
}

}  // namespace voxatlas
