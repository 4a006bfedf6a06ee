#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.hpp"

namespace voxatlas {

/// Threads that do jobs in the order they are given, for a loop that must not wait for them.
///
/// Threads: submit() and take() by one thread; the work runs on the crew's own.
/// End:     the destructor waits for jobs that have begun; those that have not are dropped.
template <class Job, class Done>
class Crew {
 public:
  /// `workers`: the work of each thread; it must not throw.
  explicit Crew(std::vector<std::function<Done(Job)>> workers)
      : wake_fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    VOX_CHECK(wake_fd_ >= 0);
    threads_.reserve(workers.size());
    for (auto& work : workers) {
      threads_.emplace_back([this, work = std::move(work)] { serve(work); });
    }
  }
  ~Crew() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    waiting_.notify_all();
    for (auto& thread : threads_) thread.join();
    ::close(wake_fd_);
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  void submit(Job job) {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
    }
    waiting_.notify_one();
  }

  /// What is done since the last time.
  std::vector<Done> take() {
    std::uint64_t count = 0;
    if (::read(wake_fd_, &count, sizeof count) < 0) return {};  // Nothing since.
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
  }

  int wake_fd() const { return wake_fd_; }  ///< Readable while take() has something.

 private:
  void serve(const std::function<Done(Job)>& work) {
    for (;;) {
      std::unique_lock lock(mutex_);
      waiting_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
      if (ending_) return;
      Job job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      Done done = work(std::move(job));
      lock.lock();
      done_.push_back(std::move(done));
      lock.unlock();
      const std::uint64_t one = 1;
      VOX_CHECK(::write(wake_fd_, &one, sizeof one) == sizeof one);
    }
  }

  int wake_fd_;
  std::mutex mutex_;
  std::condition_variable waiting_;
  std::deque<Job> jobs_;  // With all below, under mutex_.
  std::vector<Done> done_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace voxatlas
