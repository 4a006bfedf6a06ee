#include "ingest/integration_workers.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <utility>

#include "base/check.hpp"
#include "bus/convert_scan.hpp"

namespace voxatlas {

IntegrationWorkers::IntegrationWorkers(const Grid& grid, const IntegrationParameters& parameters,
                                       int workers)
    : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  VOX_CHECK(event_ >= 0);
  VOX_CHECK(workers >= 1);
  for (int i = 0; i < workers; ++i) {
    threads_.emplace_back([this, grid, parameters] { work(grid, parameters); });
  }
}

IntegrationWorkers::~IntegrationWorkers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  for (auto& thread : threads_) thread.join();
  close(event_);
}

void IntegrationWorkers::give(std::uint64_t scan, scan_t message) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.emplace_back(scan, std::move(message));
  }
  changed_.notify_all();
}

std::vector<IntegrationWorkers::Done> IntegrationWorkers::take() {
  const std::lock_guard lock(mutex_);
  std::uint64_t events = 0;
  [[maybe_unused]] const auto drained = read(event_, &events, sizeof events);  // Empty is fine.
  return std::exchange(done_, {});
}

void IntegrationWorkers::work(const Grid& grid, const IntegrationParameters& parameters) {
  Integrator integrator(grid, parameters);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    auto [number, message] = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    auto scan = to_scan(message);
    Result<ScanDelta> delta = scan ? integrator.integrate(*scan) : pass_on(scan);
    lock.lock();
    done_.push_back({number, std::move(delta)});
    const std::uint64_t one = 1;
    VOX_CHECK(write(event_, &one, sizeof one) == sizeof one);
  }
}

}  // namespace voxatlas
