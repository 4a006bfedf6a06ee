#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "render/render_tree.hpp"

namespace voxatlas {

/// Which normals to find.
enum class Normals {
  kAll,
  kAtFaces,  ///< Of cells within OccupiedCells::kMargin of the tile's faces.
};

/// Calls set(node, normal) for nodes of the tree in the middle of `around`: the normal that
/// OccupiedCells finds among the cells of the node's depth, those of the trees around it too.
/// Cost: a look at each node of the tree, and at those of its neighbours near its faces.
void find_normals(const TreesAround& around, Normals which,
                  const std::function<void(std::uint32_t, const Eigen::Vector3f&)>& set);

}  // namespace voxatlas
