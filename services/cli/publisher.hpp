#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/stream_link.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// The sending side of reliable publishing: scans go to whichever ingest has taken most of what it
/// was given, and count as durable when it says so.
///
/// Source: DESIGN section 6: at most kMaxInFlight scans are unacknowledged, because a shard keeps a
///         source's scans that come too early in memory.
/// Threads: one at a time. Memory: kMaxInFlight scans.
class Publisher {
 public:
  static constexpr std::size_t kMaxInFlight = 64;

  static Result<std::unique_ptr<Publisher>> create(Bus& bus, std::int32_t ingests);

  bool has_room() const;
  /// has_room() must hold; scans in the order of their seq.
  void publish(const scan_t& scan);

  /// Sends what can be sent, and takes note of what has become durable.
  Status pump(std::int64_t now);
  std::int64_t next_poll(std::int64_t now) const;

  std::size_t in_flight() const;
  std::uint64_t durable() const { return durable_; }  ///< Scans of this run.
  /// When any ingest was last heard of, steady microseconds; 0: never.
  std::int64_t last_heard() const;
  std::uint64_t chunks_resent() const;

 private:
  struct Ingest {
    std::unique_ptr<OutLink> link;
    std::deque<std::int64_t> unacknowledged;  ///< Message numbers.
  };
  Ingest& least_loaded();

  std::vector<Ingest> ingests_;
  std::uint64_t durable_ = 0;
};

}  // namespace voxatlas
