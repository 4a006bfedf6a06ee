#include "render/tree_normals.hpp"

#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "render/tree_walk.hpp"

namespace voxatlas {
namespace {

constexpr int kMargin = OccupiedCells::kMargin;

bool near_the_tile(const WalkedFamily& cells) {  // All of them, or none: the margin is even.
  return (cells.at.array() >= -kMargin).all() &&
         (cells.at.array() < (1 << cells.depth) + kMargin).all();
}

/// The occupied cells of each depth down to that of the tree in the middle. What lies below the
/// nodes at which a coarse tree is cut is not known: they are no leaves.
std::vector<OccupiedCells> occupied_around(const TreesAround& around, const CellsWanted& wanted) {
  const int deepest = around.middle().depth();
  std::vector<OccupiedCells> cells;
  for (int depth = 0; depth <= deepest; ++depth) cells.emplace_back(depth);
  const auto insert = [&](const WalkedFamily& family) {
    if (family.depth > deepest || !near_the_tile(family)) return false;
    if (wanted.need(family.at, family.depth)) {
      cells[static_cast<std::size_t>(family.depth)].insert(family.at, family.octants);
    }
    return true;
  };
  const auto insert_below = [&](const Eigen::Vector3i& at, int depth) {
    for (int below = depth + 1; below <= deepest; ++below) {
      const int size = 1 << (below - depth);
      cells[static_cast<std::size_t>(below)].insert(at * size, size);
    }
  };
  const auto need_below = [&](const Eigen::Vector3i& at, int depth) {
    return wanted.need_below(at, depth);
  };
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const RenderTree* tree = around.at(offset);
    if (tree == nullptr) continue;
    walk_families(*tree, offset, insert, insert_below, need_below);
  }
  return cells;
}

bool near_a_face(const Eigen::Vector3i& at, int depth) {
  return (at.array() < kMargin).any() || (at.array() >= (1 << depth) - kMargin).any();
}

/// Nodes of a depth, until there are enough to find their normals at once.
class Waiting {
 public:
  void add(std::uint32_t node, const Eigen::Vector3i& at) {
    nodes_[count_] = node;
    at_[count_++] = at;
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

std::size_t CellsWanted::block_of(const Eigen::Vector3i& at, int depth) {
  const Eigen::Vector3i block = at.unaryExpr([&](int i) { return i >> (depth - kBlockDepth); });
  return static_cast<std::size_t>(block.x() | block.y() << kBlockDepth |
                                  block.z() << 2 * kBlockDepth);
}

/// Goes through two trees of a tile side by side, for what only one of them has.
class CellsWanted::Comparison {
 public:
  Comparison(const RenderTree& before, const RenderTree& after, const Same& same)
      : before_{before, before.depth()}, after_{after, after.depth()}, same_(same) {
    for (int depth = 0; depth <= after.depth(); ++depth) changes_.cells.emplace_back(depth);
    if (after.empty()) return;
    if (before.empty()) {
      mark(Eigen::Vector3i::Zero(), 0);
    } else {
      same_(0, 0, 1);
      compare(0, 0, 0, Eigen::Vector3i::Zero());
    }
    for (std::size_t depth = kDepth; depth > 0; --depth) {
      changes_.needed_below[depth - 1] = changes_.needed[depth] | changes_.needed_below[depth];
    }
  }
  Changes take() { return std::move(changes_); }

 private:
  struct Side {
    const RenderTree& tree;
    int deepest;

    TreeChildren children(std::uint32_t node, int depth) const {
      return depth < deepest ? tree.children(node) : TreeChildren{0, 0};
    }
  };

  /// What lies below a cell that both have.
  void compare(std::uint32_t old_node, std::uint32_t new_node, int depth,
               const Eigen::Vector3i& at) {
    TreeChildren was = before_.children(old_node, depth);
    TreeChildren is = after_.children(new_node, depth);
    if ((was.octants == 0) != (is.octants == 0)) {  // A leaf fills what lies below it.
      for (int octant = 0; octant < 8; ++octant) mark(child_at(at, octant), depth + 1);
      return;
    }
    const bool alike = was.octants == is.octants;
    if (alike) same_(was.first, is.first, static_cast<std::uint32_t>(std::popcount(is.octants)));
    if (alike && depth + 1 >= before_.deepest && depth + 1 >= after_.deepest) return;
    for (std::uint32_t left = was.octants | is.octants; left != 0; left &= left - 1) {
      const int octant = std::countr_zero(left);
      const std::uint32_t bit = left & -left;
      if ((was.octants & is.octants & bit) != 0) {
        if (!alike) same_(was.first, is.first, 1);
        compare(was.first++, is.first++, depth + 1, child_at(at, octant));
        continue;
      }
      mark(child_at(at, octant), depth + 1);
      ++((was.octants & bit) != 0 ? was : is).first;
    }
  }

  /// A cell and all below it: normals within kMargin of them change, and need what lies within
  /// kMargin of these.
  void mark(const Eigen::Vector3i& at, int depth) {
    changes_.none = false;
    for (int below = depth; below < static_cast<int>(changes_.cells.size()); ++below) {
      const int size = 1 << (below - depth);
      const auto d = static_cast<std::size_t>(below);
      const Eigen::Array3i from = at.array() * size - kMargin, to = from + size + 2 * kMargin;
      changes_.cells[d].insert(from.matrix(), size + 2 * kMargin);
      if (below <= kBlockDepth) continue;
      const auto block = [&](const Eigen::Array3i& cell) -> Eigen::Array3i {
        return cell.max(0).min((1 << below) - 1).unaryExpr([&](int i) {
          return i >> (below - kBlockDepth);
        });
      };
      const Eigen::Array3i first = block(from - kMargin), last = block(to - 1 + kMargin);
      for (int z = first.z(); z <= last.z(); ++z) {
        for (int y = first.y(); y <= last.y(); ++y) {
          for (int x = first.x(); x <= last.x(); ++x) {
            changes_.needed[d].set(block_of({x, y, z}, kBlockDepth));
          }
        }
      }
    }
  }

  const Side before_, after_;
  const Same& same_;
  Changes changes_;
};

CellsWanted CellsWanted::changed(const RenderTree& before, const RenderTree& after,
                                 const Same& same) {
  CellsWanted wanted = all();
  wanted.changes_ = std::make_shared<const Changes>(Comparison(before, after, same).take());
  return wanted;
}

std::uint32_t CellsWanted::holds_of(const Eigen::Vector3i& at, int depth) const {
  if (changes_ != nullptr) return changes_->cells[static_cast<std::size_t>(depth)].holds_of(at);
  std::uint32_t octants = at_faces_ ? 0 : 0xff;
  for (int octant = 0; at_faces_ && octant < 8; ++octant) {
    octants |= std::uint32_t{near_a_face(at_octant(at, octant), depth)} << octant;
  }
  return octants;
}

bool CellsWanted::need(const Eigen::Vector3i& at, int depth) const {
  if (changes_ == nullptr || depth <= kBlockDepth) return true;
  return changes_->needed[static_cast<std::size_t>(depth)][block_of(at, depth)];
}

bool CellsWanted::need_below(const Eigen::Vector3i& at, int depth) const {
  if (changes_ == nullptr || depth < kBlockDepth) return true;
  return changes_->needed_below[static_cast<std::size_t>(depth)][block_of(at, depth)];
}

void find_normals(const TreesAround& around, const CellsWanted& wanted,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set) {
  if (wanted.none()) return;
  const auto cells = occupied_around(around, wanted);
  std::array<Waiting, kDepth + 1> waiting;
  const auto find = [&](const WalkedFamily& family) {
    const auto depth = static_cast<std::size_t>(family.depth);
    const std::uint32_t of_them = wanted.holds_of(family.at, family.depth) & family.octants;
    if (of_them == 0) return true;
    family.for_each(of_them, [&](std::uint32_t node, int octant) {
      waiting[depth].add(node, at_octant(family.at, octant));
      if (waiting[depth].full()) waiting[depth].find(cells[depth], set);
    });
    return true;
  };
  const auto need_below = [&](const Eigen::Vector3i& at, int depth) {
    return wanted.need_below(at, depth);
  };
  walk_families(
      around.middle(), Eigen::Vector3i::Zero(), find, [](const auto&, int) {}, need_below);
  for (std::size_t depth = 0; depth < cells.size(); ++depth) waiting[depth].find(cells[depth], set);
}

}  // namespace voxatlas
