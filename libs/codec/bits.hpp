#pragma once

#include <cstdint>

#include "base/bytes.hpp"

namespace voxatlas {

/// Appends numbers of 1..32 bits, the highest first, to whole bytes; the last is filled with 0.
class BitWriter {
 public:
  explicit BitWriter(Bytes& out) : out_(out) {}

  void put(std::uint32_t value, unsigned bits) {
    for (unsigned k = bits; k-- > 0;) {
      if (used_ == 0) out_.push_back(0);
      const unsigned bit = value >> k & 1;
      out_.back() = static_cast<std::uint8_t>(out_.back() | bit << (7 - used_));
      used_ = (used_ + 1) & 7;
      ++count_;
    }
  }
  std::uint64_t count() const { return count_; }

 private:
  Bytes& out_;
  unsigned used_ = 0;
  std::uint64_t count_ = 0;
};

/// The inverse. Past the end it reads 0 and is no longer ok().
class BitReader {
 public:
  explicit BitReader(ByteView in) : in_(in) {}

  std::uint32_t get(unsigned bits) {
    if (bits > 8 * in_.size() - at_) ok_ = false;
    if (!ok_) return 0;
    std::uint32_t value = 0;
    for (; bits > 0; --bits, ++at_) value = value << 1 | (in_[at_ / 8] >> (7 - at_ % 8) & 1);
    return value;
  }
  bool ok() const { return ok_; }
  /// Nothing is left but the filling, which is 0.
  bool at_end() const {
    if (!ok_ || (at_ + 7) / 8 != in_.size()) return false;
    return at_ % 8 == 0 || static_cast<std::uint8_t>(in_.back() << at_ % 8) == 0;
  }

 private:
  ByteView in_;
  std::uint64_t at_ = 0;
  bool ok_ = true;
};

}  // namespace voxatlas
