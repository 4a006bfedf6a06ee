#include "render/tree_normals.hpp"

#include <array>
#include <bit>
#include <utility>
#include <vector>

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

/// What differs between two trees of a tile, as cells of each depth and those near enough for their
/// normals to depend on them.
class Changes {
 public:
  Changes(const RenderTree& before, const RenderTree& after,
          const std::function<void(std::uint32_t, std::uint32_t)>& same)
      : before_(before), after_(after), same_(same) {
    for (int depth = 0; depth <= after.depth(); ++depth) near_.emplace_back(depth);
    if (after.empty()) return;
    if (before.empty()) {
      mark(Eigen::Vector3i::Zero(), 0);
    } else {
      compare(0, 0, 0, Eigen::Vector3i::Zero());
    }
  }
  bool any() const { return any_; }
  std::vector<OccupiedCells> take() { return std::move(near_); }

 private:
  static TreeChildren children(const RenderTree& tree, std::uint32_t node, int depth) {
    return depth < tree.depth() ? tree.children(node) : TreeChildren{0, 0};
  }

  void compare(std::uint32_t old_node, std::uint32_t new_node, int depth,
               const Eigen::Vector3i& at) {
    same_(old_node, new_node);
    TreeChildren was = children(before_, old_node, depth);
    TreeChildren is = children(after_, new_node, depth);
    if ((was.octants == 0) != (is.octants == 0)) {  // A leaf fills what lies below it.
      for (int octant = 0; octant < 8; ++octant) mark(child_at(at, octant), depth + 1);
      return;
    }
    for (std::uint32_t left = was.octants | is.octants; left != 0; left &= left - 1) {
      const int octant = std::countr_zero(left);
      const std::uint32_t bit = left & -left;
      if ((was.octants & is.octants & bit) != 0) {
        compare(was.first++, is.first++, depth + 1, child_at(at, octant));
        continue;
      }
      mark(child_at(at, octant), depth + 1);
      ++((was.octants & bit) != 0 ? was : is).first;
    }
  }

  /// A cell and all below it.
  void mark(const Eigen::Vector3i& at, int depth) {
    any_ = true;
    for (int below = depth; below < static_cast<int>(near_.size()); ++below) {
      const int size = 1 << (below - depth);
      near_[static_cast<std::size_t>(below)].insert(at * size - Eigen::Vector3i::Constant(kMargin),
                                                    size + 2 * kMargin);
    }
  }

  const RenderTree &before_, &after_;
  const std::function<void(std::uint32_t, std::uint32_t)>& same_;
  std::vector<OccupiedCells> near_;  // By depth.
  bool any_ = false;
};

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

CellsWanted CellsWanted::changed(const RenderTree& before, const RenderTree& after,
                                 const std::function<void(std::uint32_t, std::uint32_t)>& same) {
  Changes changes(before, after, same);
  CellsWanted wanted = all();
  wanted.any_changed_ = changes.any();
  wanted.changed_ = changes.take();
  return wanted;
}

bool CellsWanted::holds(const Eigen::Vector3i& at, int depth) const {
  if (at_faces_) return near_a_face(at, depth);
  return changed_.empty() || changed_[static_cast<std::size_t>(depth)].holds(at);
}

void find_normals(const TreesAround& around, const CellsWanted& wanted,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set) {
  if (wanted.none()) return;
  const auto cells = occupied_around(around);
  std::array<Waiting, kDepth + 1> waiting;
  walk_tree(around.middle(), Eigen::Vector3i::Zero(), [&](const WalkedNode& node) {
    if (wanted.holds(node.at, node.depth)) {
      const auto depth = static_cast<std::size_t>(node.depth);
      waiting[depth].add(node);
      if (waiting[depth].full()) waiting[depth].find(cells[depth], set);
    }
    return true;
  });
  for (std::size_t depth = 0; depth < cells.size(); ++depth) waiting[depth].find(cells[depth], set);
}

}  // namespace voxatlas
