#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
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
  /// Calls same(node of before, node of after) for the cells that both have.
  static CellsWanted changed(const RenderTree& before, const RenderTree& after,
                             const std::function<void(std::uint32_t, std::uint32_t)>& same);

  bool none() const { return !changed_.empty() && !any_changed_; }
  bool holds(const Eigen::Vector3i& at, int depth) const;

 private:
  explicit CellsWanted(bool at_faces) : at_faces_(at_faces) {}

  bool at_faces_ = false, any_changed_ = false;
  std::vector<OccupiedCells> changed_;  // By depth; empty: not asked for.
};

/// Calls set(node, normal) for nodes of the tree in the middle of `around`: the normal that
/// OccupiedCells finds among the cells of the node's depth, those of the trees around it too.
/// Cost: a look at each node of the tree, and at those of its neighbours near its faces.
void find_normals(const TreesAround& around, const CellsWanted& wanted,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set);

}  // namespace voxatlas
