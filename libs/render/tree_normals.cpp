#include "render/tree_normals.hpp"

#include <array>
#include <vector>

#include "render/occupied_cells.hpp"
#include "render/tree_walk.hpp"

namespace voxatlas {
namespace {

constexpr int kMargin = OccupiedCells::kMargin;

bool near_the_tile(const WalkedNode& node) {
  return (node.at.array() >= -kMargin).all() &&
         (node.at.array() < (1 << node.depth) + kMargin).all();
}

/// The occupied cells of each depth down to that of the tree in the middle. What lies below the
/// nodes at which a coarse tree is cut is not known: they are no leaves.
std::vector<OccupiedCells> occupied_around(const TreesAround& around) {
  const int deepest = around.middle().depth();
  std::vector<OccupiedCells> cells;
  for (int depth = 0; depth <= deepest; ++depth) cells.emplace_back(depth);
  const auto insert = [&](const RenderTree& tree, const WalkedNode& node) {
    cells[static_cast<std::size_t>(node.depth)].insert(node.at, 1);
    if (node.children.octants != 0 || node.depth == tree.max_depth()) return;
    for (int below = node.depth + 1; below <= deepest; ++below) {
      const int size = 1 << (below - node.depth);
      cells[static_cast<std::size_t>(below)].insert(node.at * size, size);
    }
  };
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const RenderTree* tree = around.at(offset);
    if (tree == nullptr) continue;
    walk_tree(*tree, offset, [&](const WalkedNode& node) {
      if (node.depth > deepest || !near_the_tile(node)) return false;
      insert(*tree, node);
      return true;
    });
  }
  return cells;
}

bool near_a_face(const Eigen::Vector3i& at, int depth) {
  return (at.array() < kMargin).any() || (at.array() >= (1 << depth) - kMargin).any();
}

/// Nodes of a depth, until there are enough to find their normals at once.
class Waiting {
 public:
  void add(const WalkedNode& node) {
    nodes_[count_] = node.node;
    at_[count_++] = node.at;
  }
  bool full() const { return count_ == kMost; }

  void find(const OccupiedCells& cells,
            const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set) {
    std::array<Eigen::Vector3f, kMost> normals;
    cells.normals({at_.data(), count_}, normals.data());
    for (std::size_t i = 0; i < count_; ++i) set(nodes_[i], normals[i]);
    count_ = 0;
  }

 private:
  static constexpr std::size_t kMost = OccupiedCells::kAtOnce;
  std::size_t count_ = 0;
  std::array<std::uint32_t, kMost> nodes_{};
  std::array<Eigen::Vector3i, kMost> at_;
};

}  // namespace

void find_normals(const TreesAround& around, Normals which,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set) {
  const auto cells = occupied_around(around);
  std::array<Waiting, kDepth + 1> waiting;
  walk_tree(around.middle(), Eigen::Vector3i::Zero(), [&](const WalkedNode& node) {
    if (which == Normals::kAll || near_a_face(node.at, node.depth)) {
      const auto depth = static_cast<std::size_t>(node.depth);
      waiting[depth].add(node);
      if (waiting[depth].full()) waiting[depth].find(cells[depth], set);
    }
    return true;
  });
  for (std::size_t depth = 0; depth < cells.size(); ++depth) waiting[depth].find(cells[depth], set);
}

}  // namespace voxatlas
