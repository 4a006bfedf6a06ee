#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/result.hpp"
#include "bus/endpoint.hpp"

namespace voxatlas::bench {

[[noreturn]] void give_up(const std::string& what);

template <class T>
T must(Result<T> result) {
  if (!result) give_up(result.error().message);
  return std::move(*result);
}

/// Runs `child` in a process of its own.
template <class Child>
pid_t in_child(Child child) {
  const auto pid = ::fork();
  if (pid != 0) return pid;
  child();
  std::_Exit(0);
}

/// Of a process that has ended.
struct Usage {
  double cpu_seconds = 0;
  double peak_MB = 0;  ///< Resident.
};
Usage end_child(pid_t pid);       ///< Kills it.
Usage wait_for_child(pid_t pid);  ///< Gives up where it failed.

/// What one producer did, from its first message to its last one committed.
struct Sent {
  double seconds = 0;
  double cpu_seconds = 0;
  double early_MB = 0, late_MB = 0;  ///< Resident when a quarter was committed, and at the end.
  std::uint64_t chunks_sent = 0, chunks_resent = 0, ack_bytes = 0;
};

struct Load {
  std::int64_t messages = 0;
  std::size_t message_bytes = 0;
};

/// Sends a load to whoever consume()s on this bus.
Sent produce(const std::string& url, const Load& load);
/// LCM alone, without acknowledgements: publishes the chunks of a load as fast as it can, and may
/// lose any of them.
Sent publish_raw(const std::string& url, const Load& load);
/// Takes publish_raw()'s chunks for ever and counts them; in memory shared by both.
struct RawCount {
  std::atomic<bool> ready = false;
  std::atomic<std::int64_t> bytes = 0;
  std::atomic<std::int64_t> first_at = 0, last_at = 0;  ///< Steady microseconds.
};
[[noreturn]] void count_raw(const std::string& url, RawCount& count);
/// The receive buffer that consume() is granted there, as the kernel counts it.
std::size_t consumers_buffer(const std::string& url);
/// Takes messages for ever and commits each after `work_us` of work.
[[noreturn]] void consume(const std::string& url, std::int64_t work_us);

}  // namespace voxatlas::bench
