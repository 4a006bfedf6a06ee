#include "bus/checksum.hpp"

#include <array>
#include <cstring>

#include "base/crc32c.hpp"

namespace voxatlas {
namespace {

/// The CRC-32C of numbers one after another, each in its own width, little endian.
template <class... Numbers>
std::uint32_t crc_of(Numbers... numbers) {
  std::array<std::uint8_t, (sizeof(Numbers) + ...)> bytes;
  std::size_t at = 0;
  ((std::memcpy(bytes.data() + at, &numbers, sizeof numbers), at += sizeof numbers), ...);
  return crc32c(bytes);
}

}  // namespace

std::int32_t checksum(const chunk_t& chunk) { return checksum(chunk, crc32c(chunk.data)); }

std::int32_t checksum(const chunk_t& chunk, std::uint32_t data_crc) {
  return static_cast<std::int32_t>(crc_of(chunk.session, chunk.seq, chunk.base, chunk.offered,
                                          chunk.message, chunk.index, chunk.count, chunk.kind,
                                          chunk.size, data_crc));
}

std::int32_t checksum(const ack_t& ack) {
  const auto fields =
      crc_of(ack.session, ack.incarnation, ack.received, ack.committed, ack.credit, ack.gaps);
  return static_cast<std::int32_t>(crc32c(ack.ranges, fields));
}

}  // namespace voxatlas
