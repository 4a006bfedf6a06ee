#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace voxatlas {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "formats are little endian and are copied as they lie in memory");

/// Appends little-endian values to a byte vector it borrows.
class ByteWriter {
 public:
  explicit ByteWriter(Bytes& out) : out_(out) {}

  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const auto at = out_.size();
    out_.resize(at + sizeof value);
    std::memcpy(out_.data() + at, &value, sizeof value);
  }

  /// LEB128: seven bits a byte, lowest first; one byte below 128.
  void put_varint(std::uint64_t value) {
    while (value >= 0x80) {
      out_.push_back(static_cast<std::uint8_t>(value | 0x80));
      value >>= 7;
    }
    out_.push_back(static_cast<std::uint8_t>(value));
  }

  void put_bytes(ByteView bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }

  /// A varint length, then the bytes.
  void put_string(std::string_view text) {
    put_varint(text.size());
    out_.insert(out_.end(), text.begin(), text.end());
  }

  std::size_t size() const { return out_.size(); }

 private:
  Bytes& out_;
};

/// Reads what ByteWriter wrote, from bytes that may be hostile.
///
/// Errors: the first read past the end (or over-long varint) makes the reader fail for good: reads
///         then return zero values and ok() is false. Check once, at the end of a record.
class ByteReader {
 public:
  explicit ByteReader(ByteView in) : in_(in) {}

  template <class T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    const ByteView raw = get_bytes(sizeof value);
    if (ok_) std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }

  std::uint64_t get_varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint64_t byte = get<std::uint8_t>();
      if (shift == 63 && byte > 1) break;  // Would not fit 64 bits.
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return ok_ ? value : 0;
    }
    ok_ = false;
    return 0;
  }

  /// A view into the input: lives as long as the input does.
  ByteView get_bytes(std::uint64_t count) {
    if (!ok_ || count > in_.size() - at_) {
      ok_ = false;
      return {};
    }
    const ByteView bytes = in_.subspan(at_, static_cast<std::size_t>(count));
    at_ += bytes.size();
    return bytes;
  }

  std::string get_string() {
    const ByteView bytes = get_bytes(get_varint());
    return {bytes.begin(), bytes.end()};
  }

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && at_ == in_.size(); }
  std::size_t position() const { return at_; }
  std::size_t remaining() const { return ok_ ? in_.size() - at_ : 0; }

 private:
  ByteView in_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

inline ByteView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::string_view as_text(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace voxatlas
