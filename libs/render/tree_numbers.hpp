#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/tile_key.hpp"
#include "render/render_tree.hpp"

namespace voxatlas {

/// Places a tree on the grid.
struct PlacedTree {
  TileKey key;
  const RenderTree* tree = nullptr;
};

/// Numbers the nodes of many trees through, from 1, in the order given: the numbers of a CellImage
/// that a Splatter drew.
///
/// Ownership: borrows the trees.
class TreeNumbers {
 public:
  explicit TreeNumbers(std::span<const PlacedTree> trees);

  struct Found {
    std::size_t tree;    ///< Which of the trees,
    std::uint32_t node;  ///< which of its nodes.
  };
  /// `number` is 1 .. count().
  Found find(std::uint32_t number) const;
  /// A tree's nodes: number `first` + i has the paint paints[i].
  struct Run {
    std::uint32_t first = 0, count = 0;
    const CellPaint* paints = nullptr;
  };
  /// Of the tree that a number, 1 .. count(), is of.
  Run run_of(std::uint32_t number) const {
    const Found found = find(number);
    const RenderTree& tree = *trees_[found.tree].tree;
    return {number - found.node, tree.node_count(), &tree.paint(0)};
  }
  std::uint32_t first_of(std::size_t tree) const { return first_[tree]; }
  std::uint64_t count() const { return count_; }
  bool fits() const { return count_ < ~std::uint32_t{0}; }

  const PlacedTree& tree(const Found& found) const { return trees_[found.tree]; }
  const CellPaint& paint(const Found& found) const {
    return trees_[found.tree].tree->paint(found.node);
  }
  int depth(const Found& found) const { return trees_[found.tree].tree->depth_of(found.node); }

 private:
  std::span<const PlacedTree> trees_;
  std::vector<std::uint32_t> first_;  // Number of each tree's root.
  std::uint64_t count_ = 0;
};

}  // namespace voxatlas
