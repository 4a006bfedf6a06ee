#include "render/render_tree.hpp"

#include <algorithm>
#include <bit>

namespace voxatlas {
namespace {

CellPaint paint_of(const CellState& state) {
  CellPaint paint;
  paint.log_odds = state.log_odds;
  if (state.colour.exists()) {
    paint.rgb = state.colour.rgb();
    paint.coloured = 1;
  }
  return paint;
}

}  // namespace

RenderTree::RenderTree(const TileTree& tree, std::uint64_t version) : version_(version) {
  std::vector<std::uint32_t> above, codes;  // Morton codes of a depth's nodes.
  for (int depth = 0; depth <= kDepth; ++depth) {
    const auto first = static_cast<std::uint32_t>(paints_.size());
    begin_[static_cast<std::size_t>(depth)] = first;
    codes.clear();
    tree.for_each_cell(depth, [&](const Leaf& leaf) {
      if (leaf.cell.depth != depth || !is_occupied(leaf.state.log_odds)) return;
      codes.push_back(leaf.cell.code);
      paints_.push_back(paint_of(leaf.state));
    });
    std::size_t next = 0;
    for (const std::uint32_t parent : above) {
      const std::uint32_t number = first + static_cast<std::uint32_t>(next);
      std::uint32_t mask = 0;
      for (; next < codes.size() && codes[next] >> 3 == parent; ++next)
        mask |= 1u << (codes[next] & 7);
      children_.push_back(number << 8 | mask);
    }
    above.swap(codes);
  }
  begin_[kDepth + 1] = static_cast<std::uint32_t>(paints_.size());
  paints_.shrink_to_fit();
  children_.shrink_to_fit();
}

std::uint64_t RenderTree::cell_count(int depth) const {
  const auto d = static_cast<std::size_t>(depth);
  const auto leaves = std::count_if(children_.begin(), children_.begin() + begin_[d],
                                    [](std::uint32_t children) { return (children & 0xff) == 0; });
  return begin_[d + 1] - begin_[d] + static_cast<std::uint64_t>(leaves);
}

int RenderTree::depth_of(std::uint32_t node) const {
  const auto after = std::upper_bound(begin_.begin() + 1, begin_.end(), node);
  return static_cast<int>(after - begin_.begin()) - 1;
}

CellKey RenderTree::key_of(std::uint32_t node) const {
  const int depth = depth_of(node);
  std::uint32_t code = 0;
  for (int d = depth; d > 0; --d) {
    // The parent is the last of the depth above whose children begin at or before the node, and has
    // any: a leaf has its number from those that follow.
    const auto from = children_.begin() + begin_[static_cast<std::size_t>(d - 1)];
    const auto to = children_.begin() + begin_[static_cast<std::size_t>(d)];
    auto parent = std::partition_point(
        from, to, [&](std::uint32_t children) { return children >> 8 <= node; });
    do --parent;
    while ((*parent & 0xff) == 0);
    std::uint32_t mask = *parent & 0xff;
    for (std::uint32_t skip = node - (*parent >> 8); skip > 0; --skip) mask &= mask - 1;
    code |= static_cast<std::uint32_t>(std::countr_zero(mask)) << 3 * (depth - d);
    node = static_cast<std::uint32_t>(parent - children_.begin());
  }
  return {static_cast<std::uint8_t>(depth), code};
}

std::size_t RenderTree::memory_bytes() const {
  return sizeof *this + paints_.capacity() * sizeof(CellPaint) +
         children_.capacity() * sizeof(std::uint32_t);
}

TreeNumbers::TreeNumbers(std::span<const PlacedTree> trees) : trees_(trees) {
  first_.reserve(trees.size());
  for (const auto& placed : trees) {
    first_.push_back(static_cast<std::uint32_t>(count_ + 1));
    count_ += placed.tree->node_count();
  }
}

TreeNumbers::Found TreeNumbers::find(std::uint32_t number) const {
  // The last tree that begins at or before it; of empty ones at the same place, the last.
  const auto after = std::upper_bound(first_.begin(), first_.end(), number);
  const auto tree = static_cast<std::size_t>(after - first_.begin()) - 1;
  return {tree, number - first_[tree]};
}

}  // namespace voxatlas
