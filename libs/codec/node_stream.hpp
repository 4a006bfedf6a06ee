#pragma once

#include <cstddef>
#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// A tile's canonical octree as bytes, exact, not yet compressed: the paper's lossless structure.
///
/// Source: the paper's section 5.1: a leaf bit for every node, child arrays only in inner nodes,
///         payload only in leaves. What belongs together lies together (all child arrays, all leaf
///         bits, all log-odds, all colours), which halves the bytes after Zstandard. FORMAT.md.
Bytes encode_nodes(const TileTree& tree);

/// Errors: kCorrupt for anything encode_nodes does not write. Memory: bounded by one tile.
Result<TileTree> decode_nodes(ByteView bytes);

/// Nodes of an octree of depth 7 where every node exists.
inline constexpr std::uint64_t kMaxLeaves = std::uint64_t{1} << 3 * kDepth;
inline constexpr std::uint64_t kMaxInner = (kMaxLeaves - 1) / 7;

/// encode_nodes never writes more: both masks of all inner nodes, the largest palette, and for each
/// leaf two bytes of index, a colour flag and seven bytes of colour; and the numbers between.
inline constexpr std::size_t kMaxNodeBytes =
    2 * kMaxInner + 2 * 65'536 + kMaxLeaves * 2 + kMaxLeaves / 8 + kMaxLeaves * 7 + 64;

/// The bits of the paper's own lossless format, which stores no colour count, 4 bytes of
/// probability and 3 of colour: leaves carry leaf bit and payload, inner nodes leaf bit and child
/// array. No header.
///
/// Source: the paper's sections 5.1 and 7; 122 234 001 on a full tree of depth 7.
std::uint64_t paper_lossless_bits(const TileTree::Counts& counts);

}  // namespace voxatlas
