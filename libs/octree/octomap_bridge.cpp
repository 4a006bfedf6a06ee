#include "octree/octomap_bridge.hpp"

#include <fmt/format.h>
#include <octomap/ColorOcTree.h>

#include <cmath>
#include <limits>

namespace voxatlas {
namespace {

constexpr unsigned kOctomapDepth = 16;                   // Of every OctoMap tree.
constexpr unsigned kTileDepth = kOctomapDepth - kDepth;  // Where the tile's root stands in one.
constexpr unsigned kOrigin = 1u << (kOctomapDepth - 1);  // The key of coordinate 0.
constexpr Rgb kNearlyWhite{254, 254, 254};

using Node = octomap::ColorOcTreeNode;

/// A ColorOcTree that can be grown node by node: its own setters only know the deepest nodes.
class GrowingTree : public octomap::ColorOcTree {
 public:
  using octomap::ColorOcTree::ColorOcTree;

  /// The node of a tile's cell, made with all above it.
  Node& node_of(CellKey cell) {
    if (root == nullptr) {
      root = new Node;
      ++tree_size;
    }
    // Keys of the tile are 32768 + 0..127: the octant of all ones once, then of all zeros.
    Node* node = child(root, 7);
    for (unsigned depth = 1; depth < kTileDepth; ++depth) node = child(node, 0);
    for (int depth = cell.depth - 1; depth >= 0; --depth) {
      node = child(node, cell.code >> 3 * depth & 7);
    }
    size_changed = true;
    return *node;
  }

 private:
  Node* child(Node* node, unsigned octant) {
    return nodeChildExists(node, octant) ? getNodeChild(node, octant)
                                         : createNodeChild(node, octant);
  }
};

tl::unexpected<Error> out_of_range(std::string message) {
  return fail(ErrorCode::kOutOfRange, "OctoMap tree: " + std::move(message));
}

/// The tile's cell of an OctoMap node: depth and lowest key in OctoMap's terms.
Result<CellKey> cell_of(unsigned depth, const octomap::OcTreeKey& key) {
  Index3 voxel{};
  bool inside = depth >= kTileDepth;
  for (unsigned axis = 0; axis < 3; ++axis) {
    voxel[axis] = static_cast<std::uint32_t>(key[axis]) - kOrigin;
    inside = inside && voxel[axis] < kTileVoxels;
  }
  if (!inside) {
    return out_of_range(
        fmt::format("node at depth {} and cell ({}, {}, {}) is not inside the {} "
                    "cells of a tile at the origin",
                    depth, int{key[0]} - int{kOrigin}, int{key[1]} - int{kOrigin},
                    int{key[2]} - int{kOrigin}, kTileVoxels));
  }
  return CellKey::of_voxel(voxel, static_cast<int>(depth - kTileDepth));
}

Result<CellState> state_of(const Node& node) {
  const double steps = std::round(double{node.getLogOdds()} * kLogOddsPerUnit);
  if (!(std::abs(steps) <= std::numeric_limits<LogOdds>::max())) {
    return out_of_range(fmt::format("log-odds {} is not below 8 in magnitude", node.getLogOdds()));
  }
  CellState state{static_cast<LogOdds>(steps), {}};
  if (state.log_odds >= 0 && node.isColorSet()) {
    const auto colour = node.getColor();
    state.colour.add({colour.r, colour.g, colour.b});
  }
  return state;
}

}  // namespace

std::unique_ptr<octomap::ColorOcTree> to_octomap(const TileTree& tree, const Grid& grid) {
  auto grown = std::make_unique<GrowingTree>(grid.cell_length(kDepth));
  tree.for_each_leaf([&](const Leaf& leaf) {
    Node& node = grown->node_of(leaf.cell);
    node.setLogOdds(static_cast<float>(to_float_log_odds(leaf.state.log_odds)));
    if (!leaf.state.colour.exists()) return;
    Rgb rgb = leaf.state.colour.rgb();
    if (rgb == Rgb{255, 255, 255}) rgb = kNearlyWhite;
    node.setColor(rgb.r, rgb.g, rgb.b);
  });
  if (!tree.empty()) grown->updateInnerOccupancy();  // It would look into a root that is not there.
  return grown;
}

Result<TileTree> from_octomap(const octomap::ColorOcTree& octomap_tree, const Grid& grid) {
  const double resolution = octomap_tree.getResolution(), wanted = grid.cell_length(kDepth);
  if (!(std::abs(resolution - wanted) <= 1e-6 * wanted)) {
    return out_of_range(
        fmt::format("resolution {} m, where the grid's is {} m", resolution, wanted));
  }
  TileTree tree;
  const auto end = octomap_tree.end_leafs();
  for (auto leaf = octomap_tree.begin_leafs(); leaf != end; ++leaf) {
    auto cell = cell_of(leaf.getDepth(), leaf.getIndexKey());
    if (!cell) return pass_on(cell);
    auto state = state_of(*leaf);
    if (!state) return pass_on(state);
    tree.set(*cell, *state);
  }
  return tree;
}

}  // namespace voxatlas
