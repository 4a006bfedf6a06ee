#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/cell_key.hpp"
#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// What a picture needs to know of a cell to colour it.
///
/// Layout: the log-odds, which are not negative, in steps of 1/32; a colour; a normal as its place
///         on an octahedron, 7 bits a side, right to two degrees, either way round; two flags.
class CellPaint {
 public:
  CellPaint() = default;
  /// `normal` of length 1, or zero for none.
  CellPaint(const CellState& state, const Eigen::Vector3f& normal);

  LogOdds log_odds() const { return static_cast<LogOdds>(log_odds_ << kLogOddsShift); }
  bool coloured() const { return (bits_ & kColoured) != 0; }
  Rgb rgb() const { return rgb_; }  ///< Says something only where coloured().
  /// Of about length 1; zero where there is none.
  Eigen::Vector3f normal() const;

  static constexpr int kLogOddsShift = 7;

 private:
  static constexpr std::uint16_t kColoured = 1u << 15, kNormal = 1u << 14;

  std::uint8_t log_odds_ = 0;
  Rgb rgb_;
  std::uint16_t bits_ = 0;
};
static_assert(sizeof(CellPaint) == 6);

/// Which children eight nodes have: a byte of octants each, the first node's lowest, and the number
/// of the first one's first child. The others' follow without a gap: counting bits finds them.
struct TreeLinks {
  std::array<std::uint32_t, 2> octants{};  // Not one word of 64 bits: that would cost 4 bytes more.
  std::uint32_t first_child = 0;
};

struct TreeChildren {
  std::uint32_t octants;  ///< A bit each; 0 for a leaf.
  std::uint32_t first;    ///< The node of the lowest octant; the others follow.
};
inline TreeChildren children_of(const TreeLinks* links, std::uint32_t node) {
  const TreeLinks& eight = links[node / 8];
  const std::uint64_t octants = eight.octants[0] | std::uint64_t{eight.octants[1]} << 32;
  const unsigned shift = node % 8 * 8;
  const std::uint64_t before = octants & ((std::uint64_t{1} << shift) - 1);
  return {static_cast<std::uint32_t>(octants >> shift & 0xff),
          eight.first_child + static_cast<std::uint32_t>(std::popcount(before))};
}

/// The occupied cells of one tile at every depth 0..7, for drawing: made once of a version, never
/// changed; a newer version is another tree.
///
/// Source:  the paper's section 3.4. Nodes are those of the canonical octree with anything occupied
///          inside; an inner one has the highest log-odds and the mean colour (TileTree::cell).
/// Layout:  node 0 is the root, then depth by depth, in Morton order. So a node's children lie side
///          by side, and which octants they are is all the addressing there is (TreeLinks). A leaf
///          above depth 7 has no children; depth 7 has no links.
/// Threads: never changes; safe to share.
/// Cost:    6 bytes a node, and 1.5 above depth 7: 9 to 11 bytes a drawn cell.
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
  /// Nodes first .. first + count - 1.
  struct Nodes {
    std::uint32_t first, count;
  };
  Nodes nodes_of_depth(int depth) const {
    const auto d = static_cast<std::size_t>(depth);
    return {begin_[d], begin_[d + 1] - begin_[d]};
  }
  /// Where the node is: a search in each level above it. For tests and for pointing at cells.
  CellKey key_of(std::uint32_t node) const;
  /// Of a node above depth 7.
  TreeChildren children(std::uint32_t node) const { return children_of(links_.data(), node); }
  std::span<const TreeLinks> links() const { return links_; }

  std::size_t memory_bytes() const;

 private:
  /// Adds the nodes of a depth; their Morton codes.
  std::vector<std::uint32_t> add_nodes(const TileTree& tree, int depth);
  /// Links the nodes of a depth, `above`, to those of the next.
  void add_links(const std::vector<std::uint32_t>& above, const std::vector<std::uint32_t>& codes);

  std::uint64_t version_ = 0;
  std::vector<CellPaint> paints_;
  std::vector<TreeLinks> links_;
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
  /// True where a number is of the same tree as what was found before.
  bool holds(const Found& found, std::uint32_t number) const {
    const std::uint32_t first = first_[found.tree];
    return number >= first && number - first < trees_[found.tree].tree->node_count();
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
