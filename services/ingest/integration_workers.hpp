#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "bus/wire.hpp"
#include "integrate/integrator.hpp"

namespace voxatlas {

/// Threads that integrate whole scans, each with its own Integrator: two workers take different
/// scans, so that no brick is touched twice at once and a scan's bytes do not depend on how many
/// there are.
///
/// Threads: give() and take() from one thread; the workers are inside. The destructor waits for the
///          scans being integrated and forgets those that were not begun.
class IntegrationWorkers {
 public:
  IntegrationWorkers(const Grid& grid, const IntegrationParameters& parameters, int workers);
  ~IntegrationWorkers();

  void give(std::uint64_t scan, scan_t message);

  struct Done {
    std::uint64_t scan = 0;
    Result<ScanDelta> delta;
  };
  /// What has been finished since the last call; never waits.
  std::vector<Done> take();

  /// Readable (an eventfd) when take() has something: for poll().
  int fd() const { return event_; }

 private:
  void work(const Grid& grid, const IntegrationParameters& parameters);

  int event_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::pair<std::uint64_t, scan_t>> waiting_;  // Guarded by mutex_, as all below.
  std::vector<Done> done_;
  bool stop_ = false;
  std::vector<std::thread> threads_;  // Set up before the workers run, joined at the end.
};

}  // namespace voxatlas
