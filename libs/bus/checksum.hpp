#pragma once

#include <cstdint>

#include "bus/wire.hpp"

namespace voxatlas {

/// What the field crc of a chunk or an acknowledgement must be: it covers every other field
/// (chunk_t.lcm, ack_t.lcm). Cost: that of a CRC-32C of the data, or of 60 bytes where the data's
/// is known, as it is when a chunk goes out again with another base.
std::int32_t checksum(const chunk_t& chunk);
std::int32_t checksum(const chunk_t& chunk, std::uint32_t data_crc);
std::int32_t checksum(const ack_t& ack);

}  // namespace voxatlas
