#pragma once

#include <algorithm>
#include <vector>

#include "base/bytes.hpp"
#include "codec/pyramid.hpp"

namespace voxatlas {

/// Places above this need a second byte.
inline constexpr std::size_t kNarrow = 255;

inline bool is_wide(const std::vector<LogOdds>& palette) { return palette.size() > kNarrow; }

/// Places as a plane of low bytes and, where the palette has more than 255 values, one of high.
inline void put_places(const std::vector<Place>& places, bool wide, ByteWriter& out) {
  Bytes plane(places.size());
  for (unsigned shift = 0; shift <= (wide ? 8u : 0u); shift += 8) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      plane[i] = static_cast<std::uint8_t>(places[i] >> shift);
    }
    out.put_bytes(plane);
  }
}

/// What put_places wrote.
class PlaceReader {
 public:
  PlaceReader(ByteReader& in, std::size_t count, bool wide)
      : low_(in.get_bytes(count)), high_(in.get_bytes(wide ? count : 0)) {}

  bool wide() const { return !high_.empty(); }
  unsigned low(std::size_t i) const { return low_[i]; }
  unsigned both(std::size_t i) const { return low_[i] | unsigned{high_[i]} << 8; }
  unsigned at(std::size_t i) const { return wide() ? both(i) : low(i); }

  unsigned largest() const {
    if (!wide()) return largest_byte(low_);
    unsigned largest = 0;
    for (std::size_t i = 0; i < low_.size(); ++i) largest = std::max(largest, both(i));
    return largest;
  }

  static std::uint8_t largest_byte(ByteView bytes) {
    std::uint8_t largest = 0;
    for (const auto byte : bytes) largest = std::max(largest, byte);  // In vectors.
    return largest;
  }

 private:
  ByteView low_, high_;
};

}  // namespace voxatlas
