#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geodesy/enu_frame.hpp"
#include "grid/grid.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas {

/// Where most of a model lies: tiles weighed by what is occupied in them.
///
/// Frame: `frame` stands at the middle; the axis is of length 1, horizontal, in `frame`.
struct ModelExtent {
  EnuFrame frame;
  Eigen::Vector2d long_axis;  ///< East, north: the direction of the largest spread.
  double along = 0;           ///< Standard deviations, metres: along the axis and across it.
  double across = 0;

  /// Errors: kNotFound where nothing is occupied.
  static Result<ModelExtent> of(const Grid& grid, std::span<const TileWeight> tiles);
};

/// The middle of a tile, ECEF.
inline Eigen::Vector3d middle_of(const Grid& grid, TileKey key) {
  return grid.min_corner(key) + Eigen::Vector3d::Constant(grid.tile_length() / 2);
}

}  // namespace voxatlas
