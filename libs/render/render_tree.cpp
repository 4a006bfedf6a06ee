#include "render/render_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/occupied_cells.hpp"

namespace voxatlas {
namespace {

constexpr float kNormalSteps = 63;  // From the middle of an octahedron's side to its rim.

/// The nearer half of the octahedron is a square; the other half is folded out around it.
Eigen::Vector2f fold(const Eigen::Vector2f& p) {
  const auto sign = [](float x) { return x < 0 ? -1.0f : 1.0f; };
  return {(1 - std::abs(p.y())) * sign(p.x()), (1 - std::abs(p.x())) * sign(p.y())};
}

}  // namespace

CellPaint::CellPaint(const CellState& state, const Eigen::Vector3f& normal)
    : log_odds_(static_cast<std::uint8_t>(state.log_odds >> kLogOddsShift)) {
  if (state.colour.exists()) {
    rgb_ = state.colour.rgb();
    bits_ = kColoured;
  }
  if (normal.isZero()) return;
  const Eigen::Vector3f on_sides = normal / normal.cwiseAbs().sum();
  Eigen::Vector2f p = on_sides.head<2>();
  if (on_sides.z() < 0) p = fold(p);
  const auto steps = [](float x) {
    return static_cast<unsigned>(std::lround((x + 1) * kNormalSteps)) & 0x7fu;
  };
  bits_ = static_cast<std::uint16_t>(bits_ | kNormal | steps(p.x()) << 7 | steps(p.y()));
}

Eigen::Vector3f CellPaint::normal() const {
  if ((bits_ & kNormal) == 0) return Eigen::Vector3f::Zero();
  Eigen::Vector2f p(static_cast<float>(bits_ >> 7 & 0x7f), static_cast<float>(bits_ & 0x7f));
  p = (p / kNormalSteps).array() - 1;
  const float z = 1 - p.cwiseAbs().sum();
  if (z < 0) p = fold(p);
  return Eigen::Vector3f(p.x(), p.y(), z).normalized();
}

RenderTree::RenderTree(const TileTree& tree, std::uint64_t version) : version_(version) {
  std::vector<std::uint32_t> above;  // Morton codes of the nodes of the depth above.
  for (int depth = 0; depth <= kDepth; ++depth) {
    begin_[static_cast<std::size_t>(depth)] = node_count();
    std::vector<std::uint32_t> codes = add_nodes(tree, depth);
    add_links(above, codes);
    above.swap(codes);
  }
  begin_[kDepth + 1] = node_count();
  paints_.shrink_to_fit();
  links_.shrink_to_fit();
}

std::vector<std::uint32_t> RenderTree::add_nodes(const TileTree& tree, int depth) {
  OccupiedCells occupied(depth);
  std::vector<Leaf> nodes;
  tree.for_each_cell(depth, [&](const Leaf& leaf) {
    if (!is_occupied(leaf.state.log_odds)) return;
    occupied.insert(leaf.cell);
    if (leaf.cell.depth == depth) nodes.push_back(leaf);
  });
  std::vector<std::uint32_t> codes;
  codes.reserve(nodes.size());
  for (const Leaf& node : nodes) {
    codes.push_back(node.cell.code);
    paints_.emplace_back(node.state, occupied.normal(node.cell));
  }
  return codes;
}

void RenderTree::add_links(const std::vector<std::uint32_t>& above,
                           const std::vector<std::uint32_t>& codes) {
  std::uint32_t child = node_count() - static_cast<std::uint32_t>(codes.size());
  std::uint32_t node = child - static_cast<std::uint32_t>(above.size());
  std::size_t next = 0;
  for (const std::uint32_t parent : above) {
    if (node % 8 == 0) links_.push_back({{}, child + static_cast<std::uint32_t>(next)});
    std::uint32_t octants = 0;
    for (; next < codes.size() && codes[next] >> 3 == parent; ++next) {
      octants |= 1u << (codes[next] & 7);
    }
    links_.back().octants[node / 4 % 2] |= octants << node % 4 * 8;
    ++node;
  }
}

std::uint64_t RenderTree::cell_count(int depth) const {
  const auto d = static_cast<std::size_t>(depth);
  std::uint64_t cells = begin_[d + 1] - begin_[d];
  for (std::uint32_t node = 0; node < begin_[d]; ++node) cells += children(node).octants == 0;
  return cells;
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
