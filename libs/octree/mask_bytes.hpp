#pragma once

#include <span>

#include "base/bytes.hpp"
#include "octree/brick_mask.hpp"

namespace voxatlas {

/// Bit sets as trees of bytes, FORMAT.md's "mask": a byte says which of eight parts are not zero,
/// these follow in order, down to the bytes of the set itself. One way to write each set.

/// A word: 64 bits, one level. A block: 8 words, two levels. A plane: 64 words, three levels.
void put_word(std::uint64_t word, ByteWriter& out);
void put_block(std::span<const std::uint64_t, 8> block, ByteWriter& out);
void put_plane(std::span<const std::uint64_t, 64> plane, ByteWriter& out);

/// Reads them back. False, at the block that is wrong, where the input ends or a part that was
/// announced is zero; a set that is zero as a whole is well-formed.
bool get_word(ByteReader& in, std::uint64_t& word);
bool get_block(ByteReader& in, std::span<std::uint64_t, 8> block);
bool get_plane(ByteReader& in, std::span<std::uint64_t, 64> plane);

/// The cells of depth 5 (8 bits) or 6 (64 bits) of a brick, z, y, x ascending, and their voxels.
std::uint64_t cells_of_voxels(const VoxelMask& voxels, int depth);
VoxelMask voxels_of_cells(std::uint64_t cells, int depth);

}  // namespace voxatlas
