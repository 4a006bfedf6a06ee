#include "render/render_tree.hpp"

#include <algorithm>
#include <bit>

#include "base/check.hpp"
#include "render/tree_normals.hpp"

namespace voxatlas {
RenderTree::RenderTree(const TileTree& tree, std::uint64_t version, int max_depth,
                       const RenderTree* before)
    : version_(version), max_depth_(max_depth) {
  VOX_CHECK(max_depth >= 0 && max_depth <= kDepth);
  const auto nodes = occupied_nodes(tree, max_depth);
  std::size_t count = 0;
  for (const auto& of_depth : nodes) count += of_depth.paints.size();
  paints_.reserve(count);
  std::vector<std::uint8_t> octants;
  for (std::size_t depth = 0; depth < nodes.size(); ++depth) {
    begin_[depth] = node_count();
    paints_.insert(paints_.end(), nodes[depth].paints.begin(), nodes[depth].paints.end());
    octants.insert(octants.end(), nodes[depth].octants.begin(), nodes[depth].octants.end());
  }
  begin_[kDepth + 1] = node_count();
  link(octants);
  count_cells();
  const auto keep = [&](std::uint32_t old, std::uint32_t node, std::uint32_t run) {
    for (std::uint32_t i = 0; i < run; ++i) {
      paints_[node + i].set_normal_of(before->paints_[old + i]);
    }
  };
  const bool alike = before != nullptr && before->max_depth() == max_depth;
  set_normals(TreesAround(*this),
              alike ? CellsWanted::changed(*before, *this, keep) : CellsWanted::all());
}

RenderTree RenderTree::with_borders(const TreesAround& around) const {
  VOX_CHECK(&around.middle() == this);
  RenderTree tree = *this;
  tree.set_normals(around, CellsWanted::at_faces());
  return tree;
}

void RenderTree::set_normals(const TreesAround& around, const CellsWanted& wanted) {
  find_normals(around, wanted, [this](std::uint32_t node, const Eigen::Vector3f& normal) {
    paints_[node].set_normal(normal);
  });
}

void RenderTree::link(std::span<const std::uint8_t> octants) {
  links_.resize((octants.size() + 7) / 8);
  std::uint32_t child = 1;
  for (std::size_t i = 0; i < octants.size(); ++i) {
    TreeLinks& eight = links_[i / 8];
    if (i % 8 == 0) eight.first_child = child;
    eight.octants[i / 4 % 2] |= std::uint32_t{octants[i]} << i % 4 * 8;
    child += static_cast<std::uint32_t>(std::popcount(octants[i]));
  }
}

int RenderTree::depth() const { return empty() ? 0 : depth_of(node_count() - 1); }

void RenderTree::count_cells() {
  std::uint32_t leaves = 0;
  const int deepest = depth();
  for (int depth = 0; depth <= kDepth; ++depth) {
    const Nodes nodes = nodes_of_depth(depth);
    cells_[static_cast<std::size_t>(depth)] = leaves + nodes.count;
    if (depth >= deepest) {
      leaves += nodes.count;
      continue;
    }
    for (std::uint32_t i = 0; i < nodes.count; ++i) {
      leaves += children(nodes.first + i).octants == 0;
    }
  }
}

int RenderTree::depth_of(std::uint32_t node) const {
  const auto after = std::upper_bound(begin_.begin() + 1, begin_.end(), node);
  return static_cast<int>(after - begin_.begin()) - 1;
}

CellKey RenderTree::key_of(std::uint32_t node) const {
  const int depth = depth_of(node);
  std::uint32_t code = 0;
  for (int d = depth; d > 0; --d) {
    // The parent is the last of the depth above whose children begin at or before the node and are
    // any: a leaf has its number from those that follow.
    std::uint32_t low = begin_[static_cast<std::size_t>(d - 1)];
    std::uint32_t high = begin_[static_cast<std::size_t>(d)];
    while (high - low > 1) {
      const std::uint32_t middle = low + (high - low) / 2;
      (children(middle).first <= node ? low : high) = middle;
    }
    while (children(low).octants == 0) --low;
    const TreeChildren siblings = children(low);
    std::uint32_t octants = siblings.octants;
    for (std::uint32_t skip = node - siblings.first; skip > 0; --skip) octants &= octants - 1;
    code |= static_cast<std::uint32_t>(std::countr_zero(octants)) << 3 * (depth - d);
    node = low;
  }
  return {static_cast<std::uint8_t>(depth), code};
}

std::size_t RenderTree::memory_bytes() const {
  return sizeof *this + paints_.capacity() * sizeof(CellPaint) +
         links_.capacity() * sizeof(TreeLinks);
}

}  // namespace voxatlas
