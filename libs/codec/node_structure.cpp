#include "codec/node_structure.hpp"

#include <fmt/format.h>

#include <array>

namespace voxatlas {
namespace {

/// Children of an inner node at this depth are voxels, and so leaves.
constexpr int kLastInnerDepth = kDepth - 1;

std::uint32_t octant_below(CellKey parent, CellKey cell) {
  return cell.code >> 3 * (cell.depth - parent.depth - 1) & 7;
}

void write_inner(CellKey parent, std::span<const Leaf> leaves, NodeMasks& masks) {
  std::array<std::size_t, 9> begin{};
  unsigned child_mask = 0;
  unsigned leaf_mask = 0;
  std::size_t at = 0;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    begin[octant] = at;
    while (at < leaves.size() && octant_below(parent, leaves[at].cell) == octant) ++at;
    if (at == begin[octant]) continue;
    child_mask |= 1u << octant;
    if (leaves[begin[octant]].cell.depth == parent.depth + 1) leaf_mask |= 1u << octant;
  }
  begin[8] = at;
  masks.child_masks.push_back(static_cast<std::uint8_t>(child_mask));
  if (parent.depth < kLastInnerDepth) {
    masks.leaf_masks.push_back(static_cast<std::uint8_t>(leaf_mask));
  }
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if (((child_mask & ~leaf_mask) >> octant & 1) == 0) continue;
    write_inner(parent.child(octant),
                leaves.subspan(begin[octant], begin[octant + 1] - begin[octant]), masks);
  }
}

class Reader {
 public:
  Reader(ByteView child_masks, ByteView leaf_masks, LeafCells& out)
      : child_masks_(child_masks), leaf_masks_(leaf_masks), out_(out) {}

  /// False where the masks contradict themselves or end too soon.
  bool inner(CellKey cell) {
    const unsigned children = child_masks_.get<std::uint8_t>();
    const bool last = cell.depth == kLastInnerDepth;
    const unsigned leaves = last ? children : leaf_masks_.get<std::uint8_t>();
    if (!child_masks_.ok() || !leaf_masks_.ok()) return false;
    if (children == 0 || (leaves & ~children) != 0) return false;
    if (leaves == 0xff) out_.full_parents.push_back(static_cast<std::uint32_t>(out_.cells.size()));
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      if ((leaves >> octant & 1) != 0) {
        out_.cells.push_back(cell.child(octant));
      } else if ((children >> octant & 1) != 0 && !inner(cell.child(octant))) {
        return false;
      }
    }
    return true;
  }

  bool at_end() const { return child_masks_.at_end() && leaf_masks_.at_end(); }

 private:
  ByteReader child_masks_;
  ByteReader leaf_masks_;
  LeafCells& out_;
};

}  // namespace

NodeMasks masks_of(std::span<const Leaf> leaves) {
  NodeMasks masks;
  if (leaves.empty()) return masks;
  if (leaves.front().cell.depth == 0) {
    masks.root = NodeMasks::Root::kLeaf;
    return masks;
  }
  masks.root = NodeMasks::Root::kInner;
  write_inner(CellKey{}, leaves, masks);
  return masks;
}

Result<LeafCells> leaves_of(NodeMasks::Root root, ByteView child_masks, ByteView leaf_masks) {
  LeafCells out;
  Reader reader(child_masks, leaf_masks, out);
  bool whole = true;
  if (root == NodeMasks::Root::kInner) {
    whole = reader.inner(CellKey{});
  } else if (root == NodeMasks::Root::kLeaf) {
    out.cells.emplace_back();
  }
  if (!whole || !reader.at_end()) {
    return fail(ErrorCode::kCorrupt, fmt::format("tile: {} child masks and {} leaf masks are no "
                                                 "octree",
                                                 child_masks.size(), leaf_masks.size()));
  }
  return out;
}

}  // namespace voxatlas
