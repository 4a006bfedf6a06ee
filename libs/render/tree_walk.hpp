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

/// Where a cell's child lies, in cells of its own depth.
inline Eigen::Vector3i child_at(const Eigen::Vector3i& at, int octant) {
  return 2 * at + Eigen::Vector3i(octant & 1, octant >> 1 & 1, octant >> 2);
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
