#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/bytes.hpp"

namespace voxatlas {

namespace detail {

constexpr std::array<std::int32_t, 39> make_rates() {
  std::array<std::int32_t, 39> rates{};
  for (std::size_t n = 0; n < rates.size(); ++n) {
    rates[n] = static_cast<std::int32_t>(327'680 / (5 * n + 8));
  }
  return rates;
}

}  // namespace detail

/// The chance that a bit is 1, in 1/65536, learnt from the bits that came: the n-th bit moves it by
/// 1/(n + 1.6) of the way, none by less than 1/40. Never 0 or 1. Exact values: FORMAT.md.
class Chance {
 public:
  std::uint32_t of_one() const { return one_; }
  void learn(bool bit) {
    const std::int32_t goal = bit ? kMost : kLeast;
    one_ = static_cast<std::uint16_t>(one_ + (((goal - one_) * kRates[seen_]) >> 16));
    if (seen_ + 1u < kRates.size()) ++seen_;
  }

 private:
  static constexpr std::int32_t kLeast = 32, kMost = 65'504;

  static constexpr auto kRates = detail::make_rates();

  std::uint16_t one_ = 32'768;
  std::uint8_t seen_ = 0;
};

/// A binary range coder: bits become bytes, each as long as it was unlikely.
///
/// Source: G. N. N. Martin, "Range encoding", 1979; the carry is held back in `held_` bytes as
///         Schindler's coder does.
class RangeEncoder {
 public:
  static constexpr bool kDecodes = false;

  explicit RangeEncoder(Bytes& out) : out_(out) {}

  /// Returns `bit`, so that one text can serve encoder and decoder.
  bool code(Chance& chance, bool bit) {
    const std::uint32_t ones = (range_ >> 16) * chance.of_one();
    if (bit) {
      range_ = ones;
    } else {
      low_ += ones;
      range_ -= ones;
    }
    chance.learn(bit);
    while (range_ < kLeastRange) {
      range_ <<= 8;
      shift();
    }
    return bit;
  }

  /// Once, after the last bit: as few bytes as name a number in the last range.
  void finish();

 private:
  static constexpr std::uint32_t kLeastRange = 1u << 24;

  void shift();

  Bytes& out_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffff'ffff;
  std::uint64_t held_ = 0;  ///< Bytes not yet written: one, then 0xff.
  std::uint8_t first_ = 0;  ///< The first of those held.
  bool begun_ = false;      ///< The very first byte is always 0 and never written.
};

/// The inverse. Any bytes decode to some bits; past the end they continue with zeros.
class RangeDecoder {
 public:
  static constexpr bool kDecodes = true;

  explicit RangeDecoder(ByteView in) : in_(in) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  bool code(Chance& chance, bool) {
    const std::uint32_t ones = (range_ >> 16) * chance.of_one();
    const bool bit = code_ < ones;
    if (bit) {
      range_ = ones;
    } else {
      code_ -= ones;
      range_ -= ones;
    }
    chance.learn(bit);
    while (range_ < kLeastRange) {
      range_ <<= 8;
      code_ = code_ << 8 | next();
    }
    return bit;
  }

  /// True where the bits read are those of all the bytes and of no more than the encoder drops.
  bool at_end() const { return at_ >= in_.size() && at_ - in_.size() <= 4; }

 private:
  static constexpr std::uint32_t kLeastRange = 1u << 24;

  std::uint32_t next() {
    const std::size_t at = at_++;
    return at < in_.size() ? in_[at] : 0u;
  }

  ByteView in_;
  std::size_t at_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffff'ffff;
};

}  // namespace voxatlas
