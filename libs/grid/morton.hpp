#pragma once

#include <array>
#include <cstdint>

namespace voxatlas {

/// A whole number along x, y and z: of tiles, of cells, of bricks; the header that uses it says
/// which.
using Index3 = std::array<std::uint32_t, 3>;

/// Morton code of three numbers below 2^21: bit b of axis a (x = 0) becomes bit 3 b + a.
/// Source: Morton 1966, the paper's section 3.2. Cost: a few table-free bit operations.
std::uint64_t morton_encode(const Index3& index);

/// The inverse, for codes below 2^63.
Index3 morton_decode(std::uint64_t code);

}  // namespace voxatlas
