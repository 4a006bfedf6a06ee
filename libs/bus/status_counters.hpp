#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/stream_consumer.hpp"
#include "bus/stream_producer.hpp"

namespace voxatlas {

/// The named numbers of a status (counter_t). Those that several services have are named alike, by
/// what stands here; README.md lists them.
using StatusCounters = std::vector<std::pair<std::string, double>>;

/// Of what a service receives reliably: in_held_bytes, in_credit (chunks granted and not yet
/// there), in_producers (that send now), in_chunks, in_gaps (told to producers), in_refused.
void add_incoming(const StreamConsumer& consumer, StatusCounters& counters);

/// Of all that it sends reliably, together: out_held_bytes (not yet committed), out_credit (chunks
/// it may send now), out_chunks, out_resent.
void add_outgoing(std::span<StreamProducer* const> producers, StatusCounters& counters);

/// The newest scans of the sources heard of last, each as "seq SOURCE/SESSION".
class SourceMarks {
 public:
  static constexpr std::size_t kMost = 16;

  /// A scan of a source is done with, durably. A lower seq than noted changes nothing.
  void note(const std::string& source, std::int64_t session, std::int64_t seq);
  void add_to(StatusCounters& counters) const;

 private:
  struct Entry {
    std::string source;
    std::int64_t session = 0;
    std::int64_t seq = 0;
  };
  std::deque<Entry> entries_;  ///< The last noted in front.
};

}  // namespace voxatlas
