#include "tilestore/stall_reporter.hpp"

#include <fmt/format.h>

#include <chrono>
#include <memory>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"

namespace voxatlas {

StallReporter::StallReporter(const WatchedStore& store, std::string url, std::int32_t shard,
                             std::int64_t instance)
    : store_(store), url_(std::move(url)), shard_(shard), instance_(instance) {
  thread_ = std::thread([this] { watch(); });
}

StallReporter::~StallReporter() {
  {
    const std::lock_guard guard(mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  thread_.join();
}

namespace {

/// A bus that exists from the first stall on.
class Voice {
 public:
  Status say(const std::string& url, std::int32_t shard, std::int64_t instance, std::int64_t now,
             std::int64_t waited) {
    if (!bus_) {
      auto bus = Bus::create(url);
      if (!bus) return pass_on(bus);
      bus_ = std::move(*bus);
      const auto send = [this, instance](const status_t& status) {
        status_t ours = status;
        ours.instance = instance;
        return bus_->publish(kStatusChannel, ours);
      };
      status_ = std::make_unique<StatusPublisher>(send, "tilestore", shard);
    }
    status_->set_state(false, fmt::format("waiting for the store, {} s", waited / 1'000'000));
    return status_->pump(now, [] { return StatusCounters(); });
  }

 private:
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<StatusPublisher> status_;
};

}  // namespace

void StallReporter::watch() {
  Voice voice;
  bool stalled = false;
  std::unique_lock lock(mutex_);
  while (!stopped_.wait_for(lock, std::chrono::milliseconds(250), [this] { return stop_; })) {
    const auto since = store_.waiting_since();
    const auto now = steady_utime();
    if (!since || now - *since < kPatience) {
      if (stalled) log_info("the store answers again");
      stalled = false;
      continue;
    }
    if (!stalled) log_warning("the store has not answered for {} ms", (now - *since) / 1'000);
    stalled = true;
    auto said = voice.say(url_, shard_, instance_, now, now - *since);
    if (!said) log_warning("{}", said.error().message);
  }
}

}  // namespace voxatlas
