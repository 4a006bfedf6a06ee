#pragma once

#include <memory>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "octree/tile_tree.hpp"

namespace octomap {
class ColorOcTree;
}

namespace voxatlas {

/// A tile as an OctoMap tree of the tile's own resolution, the tile's lower corner at OctoMap's
/// origin (OctoMap has 16-bit keys and float points: never give it ECEF). Exact, but for the
/// colour's count and 8.8 fraction, and pure white, which means "no colour" there and becomes
/// (254,254,254).
std::unique_ptr<octomap::ColorOcTree> to_octomap(const TileTree& tree, const Grid& grid);

/// The inverse. Errors: kOutOfRange for a tree of another resolution, a node outside the 128 cells
/// of the tile, or a log-odds that is not below 8 in magnitude; values are rounded to the lattice,
/// and the colour of a free node is dropped.
Result<TileTree> from_octomap(const octomap::ColorOcTree& octomap_tree, const Grid& grid);

}  // namespace voxatlas
