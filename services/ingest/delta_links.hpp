#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/stream_link.hpp"
#include "ingest/ingest_service.hpp"

namespace voxatlas {

/// The reliable streams from this ingest to every shard.
///
/// Memory:  what the shards have not committed. That is bounded by the sources, 64 scans each; a
///          bound here could keep out the very scan that all others wait for in a shard, so the one
///          there is, kMostBytes, is only for publishers that break the rule.
/// Threads: one at a time.
class DeltaLinks {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 30;

  static Result<std::unique_ptr<DeltaLinks>> create(Bus& bus, std::int32_t shards);

  /// Queues a scan's messages, one for each shard.
  void send(const IngestService::Outgoing& outgoing);

  /// Sends and receives what can be now, and tells `service` of every scan a shard has committed.
  Status pump(IngestService& service, std::int64_t now);
  std::int64_t next_poll(std::int64_t now);

  bool has_room() const { return held_bytes() < kMostBytes; }
  std::size_t held_bytes() const;
  std::vector<StreamProducer*> producers();

 private:
  struct Shard {
    std::unique_ptr<OutLink> link;
    std::deque<std::pair<std::int64_t, std::uint64_t>> unacked;  ///< Message number, scan.
  };
  std::vector<Shard> shards_;
};

}  // namespace voxatlas
