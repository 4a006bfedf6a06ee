#include "grid/tile_key.hpp"

#include <fmt/format.h>

namespace voxatlas {

Result<TileKey> TileKey::from_morton(std::uint64_t code) {
  if (code >> 3 * kBitsPerAxis != 0) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("tile key {:#x} has more than {} bits", code, 3 * kBitsPerAxis));
  }
  return TileKey(code);
}

Result<TileKey> TileKey::from_index(const Index3& index) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (index[axis] >> kBitsPerAxis != 0) {
      return fail(ErrorCode::kOutOfRange, fmt::format("tile index {} = {} has more than {} bits",
                                                      "xyz"[axis], index[axis], kBitsPerAxis));
    }
  }
  return TileKey(morton_encode(index));
}

}  // namespace voxatlas
