#include "store/rados_lease.hpp"

#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <list>
#include <random>
#include <system_error>

#include "base/log.hpp"

namespace voxatlas {

static constexpr const char* kLock = "owner";
static constexpr std::chrono::milliseconds kLookEvery(250);

static std::string cookie_of_this_process() {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  return fmt::format("{}:{}:{:08x}", host, ::getpid(), std::random_device()());
}

RadosLease::RadosLease(const librados::IoCtx& pool, std::string object)
    : object_(std::move(object)), cookie_(cookie_of_this_process()) {
  pool_.dup(pool);
}

int RadosLease::lock() {
  timeval duration{kSeconds, 0};
  const auto asked = Clock::now();
  const int locked = pool_.lock_exclusive(object_, kLock, cookie_, "owner of a shard", &duration,
                                          LIBRADOS_LOCK_FLAG_MAY_RENEW);
  if (locked == 0) renewed_ = asked;
  return locked;
}

bool RadosLease::fresh() const {
  return Clock::now() - renewed_.load() < std::chrono::milliseconds(kSeconds * 1'000 / 2);
}

static std::string owner_in_words(librados::IoCtx& pool, const std::string& object) {
  int exclusive = 0;
  std::string tag;
  std::list<librados::locker_t> lockers;
  if (pool.list_lockers(object, kLock, &exclusive, &tag, &lockers) < 0 || lockers.empty()) {
    return "another process";
  }
  const auto& owner = lockers.front();
  return fmt::format("{} ({} at {})", owner.cookie.substr(0, owner.cookie.rfind(':')), owner.client,
                     owner.address);
}

Result<std::unique_ptr<RadosLease>> RadosLease::take(const librados::IoCtx& pool,
                                                     const std::string& object) {
  std::unique_ptr<RadosLease> lease(new RadosLease(pool, object));
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(kSeconds + 1);
  int taken = lease->lock();
  if (taken == -EBUSY) {
    log_info("{} is owned by {}: waiting whether it lives", object,
             owner_in_words(lease->pool_, object));
  }
  while (taken == -EBUSY && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kLookEvery);
    taken = lease->lock();
  }
  if (taken == -EBUSY) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{} is in use by another process, {}: stop that one first", object,
                            owner_in_words(lease->pool_, object)));
  }
  if (taken < 0) {
    return fail(ErrorCode::kIo, fmt::format("taking the lease of {}: {}", object,
                                            std::generic_category().message(-taken)));
  }
  lease->renewer_ = std::thread([&renewed = *lease] { renewed.renew_until_stopped(); });
  return lease;
}

void RadosLease::renew_until_stopped() {
  std::unique_lock lock_of_stop(mutex_);
  while (!stopped_.wait_for(lock_of_stop, std::chrono::milliseconds(kSeconds * 1'000 / 3),
                            [this] { return stop_; })) {
    lock_of_stop.unlock();
    const int renewed = lock();
    lock_of_stop.lock();
    if (renewed != -EBUSY) continue;  // Where the cluster fails it is tried again.
    log_warning("the lease of {} has gone to {}", object_, owner_in_words(pool_, object_));
    return;  // The next write is fenced.
  }
}

RadosLease::~RadosLease() {
  if (!renewer_.joinable()) return;  // It was never taken.
  {
    const std::lock_guard guard(mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  renewer_.join();
  pool_.unlock(object_, kLock, cookie_);
}

}  // namespace voxatlas
