#include "codec/range_coder.hpp"

namespace voxatlas {

/// Moves the top byte of `low_` out. A byte 0xff may still become 0x00 by a carry, so it is held
/// back together with the byte before it.
void RangeEncoder::shift() {
  const bool carry = low_ >> 32 != 0;
  const auto top = static_cast<std::uint8_t>(low_ >> 24);
  if (carry || top != 0xff) {
    if (begun_) {
      out_.push_back(static_cast<std::uint8_t>(first_ + (carry ? 1 : 0)));
    }
    for (; held_ > 0; --held_) out_.push_back(carry ? 0x00 : 0xff);
    begun_ = true;
    first_ = top;
  } else {
    ++held_;
  }
  low_ = (low_ & 0x00ff'ffff) << 8;
}

void RangeEncoder::finish() {
  // The number in [low_, low_ + range_) that ends in the most zero bits: those bytes are dropped.
  const std::uint64_t last = low_ + range_ - 1;
  for (int bits = 32; bits >= 0; bits -= 8) {
    const std::uint64_t rounded = last >> bits << bits;
    if (rounded < low_) continue;
    low_ = rounded;
    for (int kept = 32 - bits; kept >= 0; kept -= 8) shift();
    return;
  }
}

}  // namespace voxatlas
