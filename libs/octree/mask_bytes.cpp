#include "octree/mask_bytes.hpp"

#include <bit>

namespace voxatlas {
namespace {

constexpr std::uint64_t kLow7 = 0x7f7f7f7f7f7f7f7full;

/// Bit i is set where byte i of the word is not zero.
std::uint8_t nonzero_bytes(std::uint64_t word) {
  const std::uint64_t top_bits = (((word & kLow7) + kLow7) | word) & ~kLow7;
  return static_cast<std::uint8_t>((top_bits >> 7) * 0x0102040810204080ull >> 56);
}

/// Calls visit(i) for the bits of a byte, ascending; stops and returns false when it does.
template <class Visit>
bool all_bits(unsigned byte, Visit visit) {
  for (; byte != 0; byte &= byte - 1) {
    if (!visit(static_cast<unsigned>(std::countr_zero(byte)))) return false;
  }
  return true;
}

/// A byte that says which of eight parts follow, then the parts: `get(i)` reads one, and is given
/// only those announced; each must turn out not to be zero, as `is_zero(i)` says.
template <class Get, class IsZero>
bool get_parts(ByteReader& in, Get get, IsZero is_zero) {
  const unsigned parts = in.get<std::uint8_t>();
  return all_bits(parts, [&](unsigned i) { return get(i) && !is_zero(i); }) && in.ok();
}

constexpr std::size_t kMaxWordBytes = 9;

/// Writes a word's tree and returns where it ends.
std::uint8_t* write_word(std::uint64_t word, std::uint8_t* at) {
  unsigned parts = nonzero_bytes(word);
  *at++ = static_cast<std::uint8_t>(parts);
  for (; parts != 0; parts &= parts - 1) {
    *at++ = static_cast<std::uint8_t>(word >> 8 * std::countr_zero(parts));
  }
  return at;
}

bool is_zero(std::span<const std::uint64_t> words) {
  std::uint64_t all = 0;
  for (const auto word : words) all |= word;
  return all == 0;
}

}  // namespace

void put_word(std::uint64_t word, ByteWriter& out) {
  std::array<std::uint8_t, kMaxWordBytes> bytes;
  out.put_bytes(ByteView(bytes.data(), write_word(word, bytes.data())));
}

void put_block(std::span<const std::uint64_t, 8> block, ByteWriter& out) {
  std::array<std::uint8_t, 1 + 8 * kMaxWordBytes> bytes{};
  std::uint8_t* at = bytes.data() + 1;
  for (unsigned i = 0; i < 8; ++i) {
    if (block[i] == 0) continue;
    bytes[0] |= static_cast<std::uint8_t>(1u << i);
    at = write_word(block[i], at);
  }
  out.put_bytes(ByteView(bytes.data(), at));
}

void put_plane(std::span<const std::uint64_t, 64> plane, ByteWriter& out) {
  unsigned parts = 0;
  for (std::size_t i = 0; i < 64; ++i) parts |= unsigned{plane[i] != 0} << i / 8;
  out.put(static_cast<std::uint8_t>(parts));
  all_bits(parts, [&](unsigned i) {
    put_block(plane.subspan(8 * i).first<8>(), out);
    return true;
  });
}

bool get_word(ByteReader& in, std::uint64_t& word) {
  word = 0;
  const unsigned parts = in.get<std::uint8_t>();
  const ByteView bytes = in.get_bytes(static_cast<unsigned>(std::popcount(parts)));
  if (!in.ok()) return false;
  const std::uint8_t* at = bytes.data();
  return all_bits(parts, [&](unsigned i) {
    word |= std::uint64_t{*at} << 8 * i;
    return *at++ != 0;
  });
}

bool get_block(ByteReader& in, std::span<std::uint64_t, 8> block) {
  for (auto& word : block) word = 0;
  return get_parts(
      in, [&](unsigned i) { return get_word(in, block[i]); },
      [&](unsigned i) { return block[i] == 0; });
}

bool get_plane(ByteReader& in, std::span<std::uint64_t, 64> plane) {
  for (auto& word : plane) word = 0;
  const auto part = [&](unsigned i) { return plane.subspan(8 * i).first<8>(); };
  return get_parts(
      in, [&](unsigned i) { return get_block(in, part(i)); },
      [&](unsigned i) { return is_zero(part(i)); });
}

std::uint64_t cells_of_voxels(const VoxelMask& voxels, int depth) {
  const VoxelMask& lowest = lowest_voxels(depth);
  const unsigned halving = static_cast<unsigned>(kDepth - depth);  // Cells are 2^halving voxels.
  std::uint64_t cells = 0;
  for_each_bit(both(voxels, lowest), [&](unsigned voxel) {
    const unsigned x = (voxel & 7) >> halving, y = (voxel >> 3 & 7) >> halving,
                   z = (voxel >> 6) >> halving;
    cells |= std::uint64_t{1} << (x | (y | z << (3 - halving)) << (3 - halving));
  });
  return cells;
}

VoxelMask voxels_of_cells(std::uint64_t cells, int depth) {
  const unsigned halving = static_cast<unsigned>(kDepth - depth), bits = 3 - halving;
  const unsigned last = (1u << bits) - 1;
  VoxelMask voxels{};
  for (; cells != 0; cells &= cells - 1) {
    const unsigned cell = static_cast<unsigned>(std::countr_zero(cells));
    const unsigned x = (cell & last) << halving, y = (cell >> bits & last) << halving,
                   z = (cell >> 2 * bits) << halving;
    const VoxelMask own = cell_voxels(64 * z + 8 * y + x, depth);
    for (std::size_t i = 0; i < 8; ++i) voxels[i] |= own[i];
  }
  return voxels;
}

}  // namespace voxatlas
