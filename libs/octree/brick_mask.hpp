#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "grid/cell_key.hpp"

namespace voxatlas {

inline constexpr unsigned kBrickVoxels = 512;

/// The 512 voxels of a brick, one bit each: voxel (x, y, z) is bit 8 y + x of word z. A voxel's
/// number in a brick is 64 z + 8 y + x.
using VoxelMask = std::array<std::uint64_t, 8>;

inline constexpr VoxelMask kNoVoxels{};
inline constexpr VoxelMask kAllVoxels{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};

inline bool any_of(const VoxelMask& mask) {
  std::uint64_t all = 0;
  for (const auto word : mask) all |= word;
  return all != 0;
}

/// The eight words at once, in vectors: std::popcount is a call each where a program must run on
/// every x86-64.
inline unsigned count_of(const VoxelMask& mask) {
  std::uint64_t bytes = 0;  // Each the sum of eight bytes' bits, at most 64.
  for (std::uint64_t word : mask) {
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    bytes += (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fu;
  }
  const std::uint64_t pairs = (bytes & 0x00ff00ff00ff00ffu) + (bytes >> 8 & 0x00ff00ff00ff00ffu);
  return static_cast<unsigned>(pairs * 0x0001000100010001u >> 48);
}

inline bool has_voxel(const VoxelMask& mask, unsigned voxel) {
  return (mask[voxel >> 6] >> (voxel & 63) & 1) != 0;
}

inline VoxelMask both(const VoxelMask& a, const VoxelMask& b) {
  VoxelMask result;
  for (std::size_t z = 0; z < 8; ++z) result[z] = a[z] & b[z];
  return result;
}

/// Calls visit(voxel number) for every set bit, ascending.
template <class Visit>
void for_each_bit(const VoxelMask& mask, Visit visit) {
  for (unsigned z = 0; z < 8; ++z) {
    for (std::uint64_t word = mask[z]; word != 0; word &= word - 1) {
      visit(64 * z + static_cast<unsigned>(std::countr_zero(word)));
    }
  }
}

namespace detail {

constexpr unsigned morton_of_voxel(unsigned voxel) {
  unsigned code = 0;
  for (unsigned bit = 0; bit < 3; ++bit) {
    code |= (voxel >> bit & 1) << 3 * bit;              // x
    code |= (voxel >> (bit + 3) & 1) << (3 * bit + 1);  // y
    code |= (voxel >> (bit + 6) & 1) << (3 * bit + 2);  // z
  }
  return code;
}

constexpr std::array<std::uint16_t, kBrickVoxels> make_morton_table() {
  std::array<std::uint16_t, kBrickVoxels> table{};
  for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
    table[voxel] = static_cast<std::uint16_t>(morton_of_voxel(voxel));
  }
  return table;
}

constexpr std::array<std::uint16_t, kBrickVoxels> make_voxel_table() {
  std::array<std::uint16_t, kBrickVoxels> table{};
  for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
    table[morton_of_voxel(voxel)] = static_cast<std::uint16_t>(voxel);
  }
  return table;
}

}  // namespace detail

/// Morton code inside a brick (9 bits) of a voxel number, and back.
inline constexpr auto kMortonOfVoxel = detail::make_morton_table();
inline constexpr auto kVoxelOfMorton = detail::make_voxel_table();

/// The brick a cell of depth 4..7 lies in, and its lowest voxel there.
inline unsigned brick_of(CellKey cell) { return cell.code >> 3 * (cell.depth - kBrickDepth); }
inline unsigned lowest_voxel_of(CellKey cell) {
  return kVoxelOfMorton[cell.code << 3 * (kDepth - cell.depth) & (kBrickVoxels - 1)];
}

/// The cell of depth 4..7 whose lowest voxel in `brick` is `voxel`.
inline CellKey cell_at(unsigned brick, unsigned voxel, int depth) {
  const std::uint32_t code = static_cast<std::uint32_t>(brick) << 9 | kMortonOfVoxel[voxel];
  return {static_cast<std::uint8_t>(depth), code >> 3 * (kDepth - depth)};
}

/// The voxels of a cell of depth 4..7, given its lowest voxel.
VoxelMask cell_voxels(unsigned lowest_voxel, int depth);

/// The lowest voxels of all cells of depth 4..7 of a brick: cells are counted and walked by them.
const VoxelMask& lowest_voxels(int depth);

}  // namespace voxatlas
