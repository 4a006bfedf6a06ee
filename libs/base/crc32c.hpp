#pragma once

#include <cstdint>

#include "base/bytes.hpp"

namespace voxatlas {

/// CRC-32C (Castagnoli) as in RFC 3720 and iSCSI: crc32c("123456789") is 0xE3069283.
/// Pass an earlier result as `seed` to continue over several pieces.
std::uint32_t crc32c(ByteView bytes, std::uint32_t seed = 0);

}  // namespace voxatlas
