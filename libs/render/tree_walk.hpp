#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>

#include "render/render_tree.hpp"

namespace voxatlas {

/// A node of a tree on the way through it.
struct WalkedNode {
  std::uint32_t node;
  int depth;
  Eigen::Vector3i at;     ///< Cells of its depth from a tile's lower corner.
  TreeChildren children;  ///< octants is 0 where it has none.
};

/// Where one of eight cells lies, of which octant 0 is at `at`.
inline Eigen::Vector3i at_octant(const Eigen::Vector3i& at, int octant) {
  return at + Eigen::Vector3i(octant & 1, octant >> 1 & 1, octant >> 2);
}

/// Where a cell's child lies, in cells of its own depth.
inline Eigen::Vector3i child_at(const Eigen::Vector3i& at, int octant) {
  return at_octant(2 * at, octant);
}

/// The children that a cell has, or the root by itself.
struct WalkedFamily {
  std::uint32_t first;    ///< The node of the lowest octant; the others follow.
  std::uint32_t octants;  ///< Which there are, a bit each.
  int depth;
  Eigen::Vector3i at;  ///< Where octant 0 lies, as in WalkedNode.

  /// Calls visit(node, octant) for those of them that are in a mask.
  template <class Visit>
  void for_each(std::uint32_t mask, const Visit& visit) const {
    std::uint32_t node = first;
    for (std::uint32_t left = octants; left != 0; left &= left - 1, ++node) {
      if ((mask & left & -left) != 0) visit(node, std::countr_zero(left));
    }
  }
};

/// Goes through a tree as walk_tree does, but a family at a time, which is most of the speed:
/// family(WalkedFamily) returns whether to look at what lies below it; enter(at, depth) says so of
/// one of them. leaf(at, depth) is called for leaves above the depth at which the tree was cut.
template <class Family, class Leaf, class Enter>
void walk_families(const RenderTree& tree, const Eigen::Vector3i& root_at, const Family& family,
                   const Leaf& leaf, const Enter& enter) {
  const int deepest = tree.depth();
  const auto go = [&](const auto& self, const WalkedFamily& walked) -> void {
    if (!family(walked)) return;
    if (walked.depth == deepest) {
      if (deepest == tree.max_depth()) return;
      walked.for_each(0xff, [&](auto, int octant) { leaf(at_octant(walked.at, octant), deepest); });
      return;
    }
    ChildrenInTurn below(tree.links().data(), walked.first);
    walked.for_each(0xff, [&](auto, int octant) {
      const TreeChildren children = below.next();
      const Eigen::Vector3i at = at_octant(walked.at, octant);
      if (children.octants == 0) return leaf(at, walked.depth);
      if (!enter(at, walked.depth)) return;
      self(self, WalkedFamily{children.first, children.octants, walked.depth + 1, 2 * at});
    });
  };
  if (!tree.empty()) go(go, {0, 1, 0, root_at});
}

/// Goes through a tree from its root, depth first, as far down as it is told: visit(WalkedNode)
/// returns whether to go on to the node's children. `root_at`: tiles from where places are counted.
template <class Visit>
void walk_tree(const RenderTree& tree, const Eigen::Vector3i& root_at, const Visit& visit) {
  const int deepest = tree.depth();
  const auto go = [&](const auto& self, std::uint32_t node, int depth,
                      const Eigen::Vector3i& at) -> void {
    const TreeChildren children = depth < deepest ? tree.children(node) : TreeChildren{0, 0};
    if (!visit(WalkedNode{node, depth, at, children})) return;
    std::uint32_t child = children.first;
    for (std::uint32_t left = children.octants; left != 0; left &= left - 1, ++child) {
      const int octant = std::countr_zero(left);
      self(self, child, depth + 1, child_at(at, octant));
    }
  };
  if (!tree.empty()) go(go, 0, 0, root_at);
}

}  // namespace voxatlas
