#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// The shape of an octree without what its leaves know. For encode_nodes and decode_nodes.
///
/// Layout: inner nodes depth first, children 0..7. Each has a child mask (bit i: child i exists);
///         those above depth 6 also a leaf mask (bit i: child i is a leaf), which gathers the leaf
///         bits of its children; children of depth 7 are leaves anyway.
struct NodeMasks {
  enum class Root : std::uint8_t { kNone = 0, kLeaf = 1, kInner = 2 };

  Root root = Root::kNone;
  Bytes child_masks;
  Bytes leaf_masks;
};

/// `leaves` in Morton order, as TileTree gives them.
NodeMasks masks_of(std::span<const Leaf> leaves);

/// The leaves that masks describe, in Morton order.
struct LeafCells {
  std::vector<CellKey> cells;
  /// Where, among `cells`, eight leaves of one parent begin: they must not be all alike, or the
  /// parent would have been the leaf.
  std::vector<std::uint32_t> full_parents;
};

/// Errors: kCorrupt for masks that masks_of does not make. The masks are views: their lengths say
/// how many there are.
Result<LeafCells> leaves_of(NodeMasks::Root root, ByteView child_masks, ByteView leaf_masks);

}  // namespace voxatlas
