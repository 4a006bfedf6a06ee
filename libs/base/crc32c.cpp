#include "base/crc32c.hpp"

#include <isa-l/crc.h>

#include <algorithm>

namespace voxatlas {

std::uint32_t crc32c(ByteView bytes, std::uint32_t seed) {
  constexpr std::size_t kMaxPiece = std::size_t{1} << 30;  // The library counts bytes in an int.
  std::uint32_t state = ~seed;
  while (!bytes.empty()) {
    const ByteView piece = bytes.first(std::min(bytes.size(), kMaxPiece));
    // The library's parameter is not const, yet it only reads.
    state = crc32_iscsi(const_cast<unsigned char*>(piece.data()), static_cast<int>(piece.size()),
                        state);
    bytes = bytes.subspan(piece.size());
  }
  return ~state;
}

}  // namespace voxatlas
