#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "render/occupied_cells.hpp"
#include "render/render_tree.hpp"

namespace voxatlas {

/// Which cells' normals to find.
class CellsWanted {
 public:
  static CellsWanted all() { return CellsWanted(false); }
  /// Those within OccupiedCells::kMargin of the tile's faces.
  static CellsWanted at_faces() { return CellsWanted(true); }
  /// Those of `after` around which anything differs from `before`: another tree of the same tile.
  /// Calls same(node of before, node of after, count) for the cells that both have: so many nodes
  /// from there on, in either tree.
  using Same = std::function<void(std::uint32_t, std::uint32_t, std::uint32_t)>;
  static CellsWanted changed(const RenderTree& before, const RenderTree& after, const Same& same);

  bool none() const { return changes_ != nullptr && changes_->none; }
  /// Which of eight cells, children of one cell or a tile by itself; `at` is octant 0's place.
  std::uint32_t holds_of(const Eigen::Vector3i& at, int depth) const;
  /// Whether a cell may be one on which a wanted normal depends; and whether one below it may.
  bool need(const Eigen::Vector3i& at, int depth) const;
  bool need_below(const Eigen::Vector3i& at, int depth) const;

 private:
  explicit CellsWanted(bool at_faces) : at_faces_(at_faces) {}

  class Comparison;
  static constexpr int kBlockDepth = 4;
  using Blocks = std::bitset<std::size_t{1} << 3 * kBlockDepth>;
  static std::size_t block_of(const Eigen::Vector3i& at, int depth);

  struct Changes {
    std::vector<OccupiedCells> cells;  // By depth: those whose normals may have changed.
    std::array<Blocks, kDepth + 1> needed{}, needed_below{};  // By depth, coarsely.
    bool none = true;
  };
  bool at_faces_ = false;
  std::shared_ptr<const Changes> changes_;  // Null: not asked for.
};

/// Calls set(node, normal) for nodes of the tree in the middle of `around`: the normal that
/// OccupiedCells finds among the cells of the node's depth, those of the trees around it too.
/// Cost: a look at each node of the tree, and at those of its neighbours near its faces.
void find_normals(const TreesAround& around, const CellsWanted& wanted,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set);

}  // namespace voxatlas
