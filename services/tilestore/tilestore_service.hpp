#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.hpp"
#include "atlas/scan_order.hpp"
#include "bus/status_counters.hpp"
#include "bus/wire.hpp"
#include "tilestore/commit_pace.hpp"

namespace voxatlas {

/// What a tile store does with deltas, without a network: applies them in order and durably.
///
/// Source:  DESIGN sections 6 and 7. A delta may be acknowledged when its scan's seq is at or below
/// the
///          source's mark: it is in the journal, synced, whoever computed it.
/// Memory:  ScanOrder's bound for each source; about `commit_bytes` of deltas before a commit.
/// Threads: one at a time.
class TilestoreService {
 public:
  static constexpr std::size_t kMaxCommitBytes = std::size_t{8} << 20;

  explicit TilestoreService(Atlas& atlas, std::size_t commit_bytes = kMaxCommitBytes);

  /// False: take no more deltas for now, let the ingests wait.
  bool has_room() const;

  /// Takes a delta that came as message `number` of stream `session`. One of another model, another
  /// shard, or that does not decode is refused: counted, logged, never acknowledged.
  void take(const scan_delta_t& message, std::int64_t session, std::int64_t number);

  struct Acknowledgement {
    std::int64_t session = 0;
    std::int64_t number = 0;
  };
  using Publish = std::function<void(const tile_update_t&)>;

  /// Applies all that is in order with one group commit. Calls publish(update) for each change as
  /// soon as it is durable and applied, tile by tile. Returns what is done: streams, each up to a
  /// message.
  /// Errors: kNoSpace: nothing is lost, call again later. Any other: this process must not go on.
  Result<std::vector<Acknowledgement>> commit(const Publish& publish);

  /// A compressor's result. Taken, stale, or wrong: counted, and logged where it is wrong. Returns
  /// what to publish where a lossy one has become a version of its own; it is durable already.
  std::optional<tile_update_t> take(const tile_encoded_t& message);

  struct Counters {
    std::uint64_t deltas = 0, duplicates = 0, refused = 0, commits = 0;
    std::uint64_t encoded_taken = 0, encoded_stale = 0, encoded_wrong = 0;
    std::uint64_t encoded_lossy = 0;  ///< Of those taken: a version of their own.
  };
  const Counters& counters() const { return counters_; }
  const SourceMarks& marks() const { return marks_; }  ///< The newest scans durable, by source.
  std::size_t waiting() const { return order_.waiting() + ready_.size(); }
  /// Of scans whose turn has not come: has_room() cannot refuse them, as the missing one may come
  /// behind them.
  std::size_t waiting_bytes() const { return order_.waiting_bytes(); }

 private:
  struct Pending {
    std::int64_t number = 0;
    std::string source;
    std::int64_t session = 0;
    std::int64_t seq = 0;
  };
  Result<ShardScan> to_shard_scan(const scan_delta_t& message) const;
  std::vector<Acknowledgement> acknowledge();
  tile_update_t to_update(TileKey key, std::uint64_t version, std::int64_t durable,
                          std::int8_t content, const Bytes& payload) const;

  Atlas& atlas_;
  CommitPace pace_;
  std::int64_t parameters_id_;
  ScanOrder order_;
  std::vector<ShardScan> ready_;  ///< In order, not yet durable.
  std::size_t ready_bytes_ = 0;   ///< Of their deltas.
  std::map<std::int64_t, std::deque<Pending>>
      streams_;  ///< By stream session: not yet acknowledged.
  Counters counters_;
  SourceMarks marks_;
};

}  // namespace voxatlas
