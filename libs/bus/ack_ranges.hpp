#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/bytes.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// Chunks that are missing: first .. end - 1.
struct ChunkRange {
  std::int64_t first = 0;
  std::int64_t end = 0;

  friend bool operator==(const ChunkRange&, const ChunkRange&) = default;
};

inline constexpr std::size_t kMaxGaps = 64;  ///< In one ack_t.

/// The ranges of an ack_t; of one whose sizes contradict, those that are there.
inline std::vector<ChunkRange> ranges_of(const ack_t& ack) {
  std::vector<ChunkRange> ranges;
  ByteReader reader(ack.ranges);
  for (std::int32_t i = 0; i < ack.gaps && reader.remaining() >= 16; ++i) {
    const auto first = reader.get<std::int64_t>();
    ranges.push_back({first, reader.get<std::int64_t>()});
  }
  return ranges;
}

inline void set_ranges(ack_t& ack, const std::vector<ChunkRange>& ranges) {
  ack.ranges.clear();
  ByteWriter writer(ack.ranges);
  const auto count = std::min(ranges.size(), kMaxGaps);
  for (std::size_t i = 0; i < count; ++i) {
    writer.put(ranges[i].first);
    writer.put(ranges[i].end);
  }
  ack.gaps = static_cast<std::int32_t>(count);
  ack.size = static_cast<std::int32_t>(ack.ranges.size());
}

}  // namespace voxatlas
