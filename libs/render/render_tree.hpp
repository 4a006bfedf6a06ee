#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/cell_key.hpp"
#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// What a picture needs to know of a cell to colour it.
struct CellPaint {
  LogOdds log_odds = 0;
  Rgb rgb;
  std::uint8_t coloured = 0;  ///< 0: rgb says nothing.
};
static_assert(sizeof(CellPaint) == 6);

/// The occupied cells of one tile at every depth 0..7, for drawing: made once of a version, never
/// changed; a newer version is another tree.
///
/// Source:  the paper's section 3.4. Nodes are those of the canonical octree with anything occupied
///          inside; an inner one has the highest log-odds and the mean colour (TileTree::cell).
/// Layout:  node 0 is the root, then depth by depth, in Morton order. So a node's children lie side
///          by side, and so that order is all the addressing there is: children()[i] is the number
///          of i's first child in the upper 24 bits, and a mask of its children's octants below.
///          A leaf above depth 7 has no children; depth 7 has no entry.
/// Threads: never changes; safe to share.
/// Cost:    6 bytes a node, and 4 above depth 7: about 10 bytes a drawn cell.
class RenderTree {
 public:
  RenderTree() = default;
  explicit RenderTree(const TileTree& tree, std::uint64_t version = 0);

  std::uint64_t version() const { return version_; }
  bool empty() const { return paints_.empty(); }
  std::uint32_t node_count() const { return static_cast<std::uint32_t>(paints_.size()); }
  /// How many cells there are to draw at a depth: its nodes and the leaves above it.
  std::uint64_t cell_count(int depth) const;

  /// `node` is below node_count().
  const CellPaint& paint(std::uint32_t node) const { return paints_[node]; }
  int depth_of(std::uint32_t node) const;
  /// Where the node is: a search in each level above it. For tests and for pointing at cells.
  CellKey key_of(std::uint32_t node) const;
  std::span<const std::uint32_t> children() const { return children_; }

  std::size_t memory_bytes() const;

 private:
  std::uint64_t version_ = 0;
  std::vector<CellPaint> paints_;
  std::vector<std::uint32_t> children_;
  std::array<std::uint32_t, kDepth + 2> begin_{};  // Of each depth; then the end.
};

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
