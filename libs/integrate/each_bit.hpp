#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace voxatlas {

/// A bit for each brick, or each cell of depth 0..4, of a tile, in Morton order.
using TopBits = std::array<std::uint64_t, 64>;

/// Calls visit(number) for every set bit, ascending.
template <class Visit>
void for_each_bit_of(std::uint64_t word, const Visit& visit) {
  for (; word != 0; word &= word - 1) visit(static_cast<std::uint32_t>(std::countr_zero(word)));
}
template <class Visit>
void for_each_top(const TopBits& top, const Visit& visit) {
  for (std::uint32_t w = 0; w < top.size(); ++w) {
    for_each_bit_of(top[w], [&](std::uint32_t bit) { visit(w << 6 | bit); });
  }
}

}  // namespace voxatlas
