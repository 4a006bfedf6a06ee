#include "octree/mask_bytes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/mask_bytes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOX_MASK_BYTES_ONCE
#define VOX_MASK_BYTES_ONCE

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace voxatlas {
namespace {

constexpr std::uint64_t kLow7 = 0x7f7f7f7f7f7f7f7full;
constexpr std::size_t kMaxWordBytes = 9, kMaxBlockBytes = 1 + 8 * kMaxWordBytes;
/// A whole vector is written and read where a word's bytes are.
constexpr std::size_t kSlack = 16;

/// Bit i is set where byte i of the word is not zero.
inline unsigned nonzero_bytes(std::uint64_t word) {
  const std::uint64_t top_bits = (((word & kLow7) + kLow7) | word) & ~kLow7;
  return static_cast<unsigned>((top_bits >> 7) * 0x0102040810204080ull >> 56);
}

/// For each byte of parts: where the announced bytes of a word are, in order, and back: which of
/// the bytes that follow each byte of the word is, 0x80 where it is none.
struct Shuffles {
  std::uint8_t gather[256][8], scatter[256][8];
};
constexpr Shuffles make_shuffles() {
  Shuffles all{};
  for (unsigned parts = 0; parts < 256; ++parts) {
    std::uint8_t count = 0;
    for (std::uint8_t i = 0; i < 8; ++i) all.gather[parts][i] = 0x80;
    for (std::uint8_t i = 0; i < 8; ++i) {
      all.scatter[parts][i] = 0x80;
      if ((parts >> i & 1) == 0) continue;
      all.scatter[parts][i] = count;
      all.gather[parts][count++] = i;
    }
  }
  return all;
}
alignas(64) constexpr Shuffles kShuffles = make_shuffles();

}  // namespace
}  // namespace voxatlas
#endif

HWY_BEFORE_NAMESPACE();
namespace voxatlas {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// to[i] = from[indices[i]], 0 where an index is 0x80, for eight bytes.
HWY_ATTR void look_up(const std::uint8_t* from, const std::uint8_t* indices, std::uint8_t* to) {
#if HWY_TARGET == HWY_SCALAR  // Its vectors are of one byte.
  for (int i = 0; i < 8; ++i) to[i] = indices[i] < 8 ? from[indices[i]] : std::uint8_t{0};
#else
  const hn::FixedTag<std::uint8_t, 8> d;
  hn::StoreU(hn::TableLookupBytesOr0(hn::LoadU(d, from), hn::Load(d, indices)), d, to);
#endif
}

/// Writes a word's tree, and beyond it up to 8 bytes, and returns where it ends.
HWY_ATTR std::uint8_t* write_word(std::uint64_t word, std::uint8_t* at) {
  const unsigned parts = nonzero_bytes(word);
  std::array<std::uint8_t, 8> bytes;
  std::memcpy(bytes.data(), &word, sizeof word);
  *at = static_cast<std::uint8_t>(parts);
  look_up(bytes.data(), kShuffles.gather[parts], at + 1);
  return at + 1 + std::popcount(parts);
}

/// Reads a word's tree, of which 9 bytes may be read. Returns where it ends, nullptr where an
/// announced byte is zero.
HWY_ATTR const std::uint8_t* read_word(const std::uint8_t* at, std::uint64_t& word) {
  const unsigned parts = *at;
  std::array<std::uint8_t, 8> bytes;
  look_up(at + 1, kShuffles.scatter[parts], bytes.data());
  std::memcpy(&word, bytes.data(), sizeof word);
  return nonzero_bytes(word) == parts ? at + 1 + std::popcount(parts) : nullptr;
}

HWY_ATTR std::uint8_t* write_block(const std::uint64_t* block, std::uint8_t* at) {
  std::uint8_t* const parts = at++;
  unsigned present = 0;
  for (unsigned i = 0; i < 8; ++i) {
    if (block[i] == 0) continue;
    present |= 1u << i;
    at = write_word(block[i], at);
  }
  *parts = static_cast<std::uint8_t>(present);
  return at;
}

HWY_ATTR const std::uint8_t* read_block(const std::uint8_t* at, std::uint64_t* block) {
  const unsigned parts = *at++;
  for (unsigned i = 0; i < 8; ++i) {
    block[i] = 0;
    if ((parts >> i & 1) == 0) continue;
    at = read_word(at, block[i]);
    if (at == nullptr || block[i] == 0) return nullptr;
  }
  return at;
}

}  // namespace HWY_NAMESPACE
}  // namespace voxatlas
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace voxatlas {
namespace {

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

bool is_zero(std::span<const std::uint64_t> words) {
  std::uint64_t all = 0;
  for (const auto word : words) all |= word;
  return all == 0;
}

}  // namespace

HWY_EXPORT(write_block);
HWY_EXPORT(read_block);

void put_word(std::uint64_t word, ByteWriter& out) {
  std::array<std::uint8_t, kMaxWordBytes> bytes;
  bytes[0] = static_cast<std::uint8_t>(nonzero_bytes(word));
  std::size_t size = 1;
  all_bits(bytes[0], [&](unsigned i) {
    bytes[size++] = static_cast<std::uint8_t>(word >> 8 * i);
    return true;
  });
  out.put_bytes(ByteView(bytes.data(), size));
}

void put_block(std::span<const std::uint64_t, 8> block, ByteWriter& out) {
  std::array<std::uint8_t, kMaxBlockBytes + kSlack> bytes;
  const auto* end = HWY_DYNAMIC_DISPATCH(write_block)(block.data(), bytes.data());
  out.put_bytes(ByteView(bytes.data(), end));
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
  // Read where it lies, or from a copy where whole vectors would reach beyond the input.
  std::array<std::uint8_t, kMaxBlockBytes + kSlack> copy;
  const ByteView rest = ByteReader(in).get_bytes(in.remaining());
  const std::uint8_t* begin = rest.data();
  if (rest.size() < copy.size()) {
    std::fill(std::copy(rest.begin(), rest.end(), copy.begin()), copy.end(), std::uint8_t{0});
    begin = copy.data();
  }
  const auto* end = HWY_DYNAMIC_DISPATCH(read_block)(begin, block.data());
  if (end == nullptr) return false;
  in.get_bytes(static_cast<std::uint64_t>(end - begin));
  return in.ok();
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
#endif
