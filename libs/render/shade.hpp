#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"
#include "render/image.hpp"
#include "render/tree_numbers.hpp"
#include "render/workers.hpp"

namespace voxatlas {

/// What a cell's colour tells.
enum class Colouring {
  kRgb,          ///< What scans saw; cells without colour are grey by height.
  kHeight,       ///< Height above the scene's ground.
  kProbability,  ///< From 0.5 to 1.
  kLeafDepth,    ///< The depth of its leaf.
  /// Height above the ellipsoid, to 2 cm within 500 m: up the ramp for 50 m and down again for the
  /// next, so that a height has the same colour in every picture.
  kEllipsoid,
  /// Which way the surface looks: east in red, north in green, up in blue; grey where unknown.
  kNormal,
};

/// "rgb", "height", "probability", "depth", "ellipsoid", "normal".
const char* name_of(Colouring colouring);
/// Errors: kInvalid, naming the word and the choice.
Result<Colouring> colouring_of(const std::string& name);

/// Which way is up in a scene, where its ground is, and how high it rises above it.
///
/// Units: metres along `up`; ground counts from the camera.
/// The ground is that height below which 5 % of the cells lie: a few points that a window mirrored
/// underground do not count. The rise leaves out the highest 1 %, and is 5 to 25 m.
struct SceneHeights {
  Eigen::Vector3d up_ecef = Eigen::Vector3d::UnitZ();
  double ground = 0;
  double rise = 25;
};
/// Of the trees' cells of depth 5, or the deepest that a coarse one has.
SceneHeights scene_heights(const Camera& camera, const Grid& grid,
                           std::span<const PlacedTree> trees);

/// The picture: each cell in its colour, under a high sun from the south-east and eye-dome light;
/// behind them the sky, lighter towards the horizon, and pale grey below it, where nothing is
/// known. Heights are those of the points that pixels show.
/// Cost: some 20 ns a pixel, shared by the workers.
void shade(const CellImage& cells, const TreeNumbers& numbers, const Camera& camera,
           const Grid& grid, const SceneHeights& heights, Colouring colouring, Workers& workers,
           Image& image);

}  // namespace voxatlas
