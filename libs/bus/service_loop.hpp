#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/status_counters.hpp"

namespace voxatlas {

/// Of this build, such as "0.1.0": what its statuses say.
const char* voxatlas_version();

/// Sets the flag that stop_requested() reads, on SIGINT and SIGTERM. Once, in main.
void stop_on_signals();
bool stop_requested();

/// The one loop of a service: waits for any of its connections, runs their handlers, then `work`,
/// until a signal asks to stop or `work` says so.
///
/// Threads: everything runs on the calling thread.
/// Errors:  a bus that can no longer be read ends the loop with its error.
struct ServiceLoop {
  std::vector<Bus*> buses;
  /// Other descriptors that call `work` when readable, such as a worker's eventfd; `work` drains
  /// them.
  std::vector<int> wake_fds;
  /// Called after every wake-up and at least every 500 ms. Returns when it wants to be called again
  /// at the latest (steady microseconds), or an error that ends the loop.
  std::function<Result<std::int64_t>(std::int64_t now)> work;

  /// Optional: asked after each `work`; true ends the loop without an error.
  std::function<bool()> finished;

  Status run();
};

/// What a service tells of itself twice a second (status_t). To its counters it adds what is true
/// of any process on the bus: kernel_drops (socket_drops()), undecodable.
class StatusPublisher {
 public:
  using Send = std::function<Status(const status_t&)>;

  StatusPublisher(Bus& bus, std::string service, std::int32_t index);
  /// Of a service that is not on the bus itself: `send` brings it there.
  StatusPublisher(Send send, std::string service, std::int32_t index);

  void set_state(bool ready, std::string state);
  std::int64_t instance() const { return status_.instance; }
  /// Publishes where half a second has passed since the last time, or the state has changed.
  /// `counters` is called only then.
  Status pump(std::int64_t now, const std::function<StatusCounters()>& counters);
  std::int64_t next_pump() const;  ///< When it will publish; steady microseconds.

 private:
  Bus* bus_ = nullptr;
  Send send_;
  status_t status_;
  std::int64_t last_sent_ = 0;
  bool changed_ = true;
};

}  // namespace voxatlas
