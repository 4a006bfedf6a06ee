#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.hpp"
#include "base/result.hpp"

namespace voxatlas {

/// Puts each source's scans in seq order before they are applied: later ones wait, bounded.
///
/// Source: DESIGN section 6. A scan's place is (source, session, seq), seq from 0 without gaps.
/// Errors: kInvalid for a scan more than kMaxWaiting after the next one wanted, and for a scan
/// whose
///         `acked_below` lies above what the shard has applied: the shard has lost acknowledged
///         scans, an alarm.
/// Threads: one at a time.
class ScanOrder {
 public:
  static constexpr std::int64_t kMaxWaiting = 64;

  /// Where a source's session stands, from the atlas's marks at start.
  void start_from(const std::vector<Mark>& marks);

  enum class Offer { kTaken, kDuplicate };
  /// A duplicate (applied, or waiting already) is dropped. `acked_below`: every scan below it has
  /// been acknowledged by all shards.
  Result<Offer> offer(ShardScan scan, std::int64_t acked_below);

  /// The scans that may be applied now, in order; they count as applied from here on.
  std::vector<ShardScan> take_ready();

  std::size_t waiting() const;
  std::size_t waiting_bytes() const;  ///< Of the deltas of those.
  /// The next seq wanted of a source's session.
  std::int64_t next(const std::string& source, std::int64_t session) const;

 private:
  using Session = std::pair<std::string, std::int64_t>;
  struct Queue {
    std::int64_t next = 0;
    std::map<std::int64_t, ShardScan> waiting;
  };
  std::map<Session, Queue> queues_;
};

}  // namespace voxatlas
