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
/// Threads: one at a time. Memory: each stream's send buffer, plus what waits for room in it.
class DeltaLinks {
 public:
  static Result<std::unique_ptr<DeltaLinks>> create(Bus& bus, std::int32_t shards);

  /// Queues a scan's messages, one for each shard.
  void send(IngestService::Outgoing outgoing);

  /// Sends and receives what can be now, and tells `service` of every scan a shard has committed.
  Status pump(IngestService& service, std::int64_t now);
  std::int64_t next_poll(std::int64_t now);

  /// False where a slow shard makes messages pile up: take no more scans.
  bool has_room() const;
  std::size_t held_bytes();
  StreamProducer::Counters counters();  ///< Of all streams together.

 private:
  struct Shard {
    std::unique_ptr<OutLink> link;
    std::deque<std::pair<std::uint64_t, Bytes>>
        waiting;  ///< For room in the stream: scan, message.
    std::deque<std::pair<std::int64_t, std::uint64_t>> unacked;  ///< Message number, scan.
  };
  std::vector<Shard> shards_;
};

}  // namespace voxatlas
