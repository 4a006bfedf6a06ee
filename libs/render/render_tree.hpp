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
#include "render/cell_paint.hpp"
#include "render/occupied_nodes.hpp"

namespace voxatlas {

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

/// Of a node and those after it, one by one: only the first one's bits are counted the long way.
class ChildrenInTurn {
 public:
  ChildrenInTurn(const TreeLinks* links, std::uint32_t node)
      : links_(links), node_(node), first_(children_of(links, node).first) {}

  TreeChildren next() {
    const std::uint32_t octants = links_[node_ / 8].octants[node_ / 4 % 2] >> node_ % 4 * 8 & 0xff;
    const TreeChildren children{octants, first_};
    first_ += kBits[octants];
    ++node_;
    return children;
  }

 private:
  static constexpr std::array<std::uint8_t, 256> kBits = [] {
    std::array<std::uint8_t, 256> bits{};
    for (unsigned i = 0; i < 256; ++i) bits[i] = static_cast<std::uint8_t>(std::popcount(i));
    return bits;
  }();

  const TreeLinks* links_;
  std::uint32_t node_, first_;
};

class RenderTree;
class CellsWanted;

/// A tree and its 26 neighbours.
///
/// Ownership: borrows them.
class TreesAround {
 public:
  explicit TreesAround(const RenderTree& middle) { set({0, 0, 0}, &middle); }

  /// `offset`: tiles from the middle, -1..1 on each axis. nullptr: nothing is known there.
  void set(const Eigen::Vector3i& offset, const RenderTree* tree) { trees_[index(offset)] = tree; }
  const RenderTree* at(const Eigen::Vector3i& offset) const { return trees_[index(offset)]; }
  const RenderTree& middle() const { return *trees_[13]; }

 private:
  static std::size_t index(const Eigen::Vector3i& offset) {
    return static_cast<std::size_t>(13 + offset.x() + 3 * offset.y() + 9 * offset.z());
  }
  std::array<const RenderTree*, 27> trees_{};
};

/// The occupied cells of one tile at every depth 0..7, for drawing: made once of a version, never
/// changed; a newer version is another tree.
///
/// Source:  the paper's section 3.4. Nodes are those of the canonical octree with anything occupied
///          inside; an inner one has the highest log-odds and the mean colour (TileTree::cell).
/// Layout:  node 0 is the root, then depth by depth, in Morton order. So a node's children lie side
///          by side, and which octants they are is all the addressing there is (TreeLinks). A leaf
///          above depth 7 has no children; the deepest nodes have no links.
/// Normals: from the occupied cells of the tile alone; with_borders() looks across its faces, too.
/// Threads: never changes; safe to share.
/// Cost:    6 bytes a node, and 1.5 above depth 7: 9 to 11 bytes a drawn cell.
class RenderTree {
 public:
  RenderTree() = default;
  /// A coarse tree ends at `max_depth`, 0..7: there, inner nodes are drawn as leaves are.
  /// `before`: an older tree of the same tile; not null: normals of which nothing near has changed
  /// are taken from it. So those near the faces may be what its with_borders() gave them; all
  /// others are the same as without it. Ignored where it ends at another depth.
  explicit RenderTree(const TileTree& tree, std::uint64_t version = 0, int max_depth = kDepth,
                      const RenderTree* before = nullptr);

  /// The same tree, its normals near the faces found anew with what is known of the tiles around
  /// it. `around` has this tree in its middle. The result depends on the trees around alone, not on
  /// what this one's normals were made of.
  RenderTree with_borders(const TreesAround& around) const;

  std::uint64_t version() const { return version_; }
  bool empty() const { return paints_.empty(); }
  std::uint32_t node_count() const { return static_cast<std::uint32_t>(paints_.size()); }
  /// Where a coarse tree was cut; else 7.
  int max_depth() const { return max_depth_; }
  /// The depth of its deepest nodes; 0 when empty.
  int depth() const;
  /// How many cells there are to draw at a depth: its nodes and the leaves above it.
  std::uint64_t cell_count(int depth) const { return cells_[static_cast<std::size_t>(depth)]; }

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
  /// Of a node above depth().
  TreeChildren children(std::uint32_t node) const { return children_of(links_.data(), node); }
  std::span<const TreeLinks> links() const { return links_; }

  std::size_t memory_bytes() const;

 private:
  /// Links each node above the last depth to its children, given which it has.
  void link(std::span<const std::uint8_t> octants);
  void count_cells();
  void set_normals(const TreesAround& around, const CellsWanted& wanted);

  std::uint64_t version_ = 0;
  int max_depth_ = kDepth;
  std::vector<CellPaint> paints_;
  std::vector<TreeLinks> links_;
  std::array<std::uint32_t, kDepth + 2> begin_{};  // Of each depth; then the end.
  std::array<std::uint32_t, kDepth + 1> cells_{};  // To draw at each depth.
};

}  // namespace voxatlas
