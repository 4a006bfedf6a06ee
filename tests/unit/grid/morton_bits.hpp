#pragma once

#include "grid/morton.hpp"

namespace voxatlas::test {

/// Oracle: a Morton code written bit by bit.
inline std::uint64_t morton_by_bits(const Index3& index) {
  std::uint64_t code = 0;
  for (unsigned bit = 0; bit < 21; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      code |= std::uint64_t{index[axis] >> bit & 1u} << (3 * bit + axis);
    }
  }
  return code;
}

}  // namespace voxatlas::test
