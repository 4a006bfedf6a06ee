#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <rados/librados.hpp>
#include <string>
#include <thread>

#include "base/result.hpp"

namespace voxatlas {

/// Who owns an object, told by the cluster: a lock (cls_lock) that runs out unless it is renewed,
/// so that a dead owner's is free again after kSeconds. It keeps two live processes from taking
/// a shard from each other in turns. No write rests on it: that is the epoch's part.
///
/// Threads: a thread of its own renews it every third of its time.
class RadosLease {
 public:
  static constexpr int kSeconds = 5;

  /// Waits for another's lease to run out, and a second more.
  /// Errors: kUnavailable names the owner, who lives; kIo.
  static Result<std::unique_ptr<RadosLease>> take(const librados::IoCtx& pool,
                                                  const std::string& object);
  ~RadosLease();  ///< Gives it back.

  /// Nobody else can have taken it: it was renewed less than half its time ago. Saves a question to
  /// the cluster; what was written on the strength of it is compared with the epoch all the same.
  bool fresh() const;

 private:
  RadosLease(const librados::IoCtx& pool, std::string object);
  int lock();
  void renew_until_stopped();

  librados::IoCtx pool_;
  std::string object_;
  std::string cookie_;  // host:pid:number; what another is told of the owner.

  using Clock = std::chrono::steady_clock;
  std::atomic<Clock::time_point> renewed_{
      Clock::time_point()};  // When the last lock was asked for.

  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;  // Guarded by mutex_.
  std::thread renewer_;
};

}  // namespace voxatlas
