#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/stream_link.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// The sending side of reliable publishing: scans go to whichever ingest has taken most of what it
/// was given, to equals in turn, and count as durable when it says so.
///
/// Source:  DESIGN section 6: at most kMaxInFlight scans are unacknowledged, because a shard keeps
///          a source's scans that come too early in memory.
/// Ingests: those it is created for, and any that says on the bus that it is ready. One that has
///          been silent for kGoneUs gets no more, and what it had goes to others: a scan that two
///          have counts once. With no other there, it keeps it until it is back.
/// Threads: one at a time. Memory: kMaxInFlight scans, no more of them once kMostBytes are held.
class Publisher {
 public:
  static constexpr std::size_t kMaxInFlight = 64;
  static constexpr std::size_t kMostBytes = std::size_t{128} << 20;
  static constexpr std::int64_t kGoneUs = 2'000'000;

  /// `bus` must outlive it.
  static Result<std::unique_ptr<Publisher>> create(Bus& bus, std::int32_t ingests,
                                                   std::int64_t now);
  ~Publisher();

  bool has_room(std::int64_t now) const;
  /// has_room() must hold; scans in the order of their seq.
  void publish(const scan_t& scan, std::int64_t now);

  /// Sends what can be sent, takes note of what has become durable, of ingests that came and went.
  Status pump(std::int64_t now);
  std::int64_t next_poll(std::int64_t now) const;

  std::size_t in_flight() const;
  std::int64_t durable_below() const;                 ///< Every scan with a lower seq is durable.
  std::uint64_t durable() const { return durable_; }  ///< Scans of this run.
  /// How long after publish() they were known to be durable; microseconds.
  struct Delay {
    std::int64_t sum = 0, most = 0;
  };
  const Delay& delay() const { return delay_; }
  /// When any ingest was last heard of, steady microseconds; 0: never.
  std::int64_t last_heard() const;
  std::uint64_t chunks_resent() const;
  std::uint64_t moved() const { return moved_; }  ///< Scans given to another ingest.

 private:
  struct InFlight {
    std::int64_t number = 0;  ///< Of the message in its ingest's stream,
    std::int64_t seq = 0;     ///< of the scan in its source.
    std::int64_t published_at = 0;
  };
  struct Homeless {
    std::int64_t seq = 0, published_at = 0;
    Bytes scan;
  };
  struct Ingest {
    std::unique_ptr<OutLink> link;
    std::int64_t known_since = 0;
    std::int64_t ready_at = 0;    ///< When it last said that it is ready; 0: never.
    std::uint64_t last_turn = 0;  ///< Of turns_, when it was given a scan; 0: never.
    std::deque<InFlight> unacknowledged;

    std::int64_t last_heard() const;
    bool is_there(std::int64_t now) const;
  };

  explicit Publisher(Bus& bus) : bus_(bus) {}
  Status add(std::int32_t index, std::int64_t now);
  Status note_ready(std::int64_t now);
  Status leave_the_gone(std::int64_t now);
  void settle_homeless(std::int64_t now);
  Ingest* least_loaded(std::int64_t now);
  void give(Ingest& ingest, Homeless scan);

  Bus& bus_;
  Bus::Subscription statuses_ = 0;
  std::map<std::int32_t, Ingest> ingests_;
  std::vector<std::int32_t> ready_;  ///< Ingests heard of since the last pump().
  std::deque<Homeless> homeless_;    ///< Scans of ingests that went, not given to others yet.
  std::int64_t next_seq_ = 0;        ///< After the last one published.
  std::uint64_t turns_ = 0;          ///< Scans given to ingests.
  std::uint64_t durable_ = 0, moved_ = 0, resent_by_gone_ = 0;
  Delay delay_;
};

}  // namespace voxatlas
