#pragma once

#include <array>
#include <cstdint>

namespace voxatlas {

/// A whole number along x, y and z: of tiles, of cells, of bricks; the header that uses it says
/// which.
using Index3 = std::array<std::uint32_t, 3>;

namespace detail {

/// Moves bit b of a number below 2^21 to bit 3 b, halving the groups that move together.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// The inverse; bits that are not multiples of three are ignored.
constexpr std::uint32_t gather_bits(std::uint64_t x) {
  x &= 0x1249249249249249;
  x = (x | x >> 2) & 0x10c30c30c30c30c3;
  x = (x | x >> 4) & 0x100f00f00f00f00f;
  x = (x | x >> 8) & 0x1f0000ff0000ff;
  x = (x | x >> 16) & 0x1f00000000ffff;
  x = (x | x >> 32) & 0x1fffff;
  return static_cast<std::uint32_t>(x);
}

}  // namespace detail

/// Morton code of three numbers below 2^21: bit b of axis a (x = 0) becomes bit 3 b + a.
/// Source: Morton 1966, the paper's section 3.2. Cost: a few table-free bit operations.
constexpr std::uint64_t morton_encode(const Index3& index) {
  return detail::spread_bits(index[0]) | detail::spread_bits(index[1]) << 1 |
         detail::spread_bits(index[2]) << 2;
}

/// The inverse, for codes below 2^63.
constexpr Index3 morton_decode(std::uint64_t code) {
  return {detail::gather_bits(code), detail::gather_bits(code >> 1),
          detail::gather_bits(code >> 2)};
}

}  // namespace voxatlas
