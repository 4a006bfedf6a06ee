#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "grid/grid.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// What a camera can see: the space between six planes.
///
/// Frame:   ECEF; kept relative to the camera, so that a box of 10 cm on the Earth's surface is
///          judged with full precision.
/// Promise: may_see() is never false for a box that has a point in view; it may be true for some
///          that have none (a large box past an edge of the frustum).
class Frustum {
 public:
  explicit Frustum(const Camera& camera);

  bool may_see(const Box& box) const;

 private:
  struct Plane {
    Eigen::Vector3d normal;  // Inwards, length 1.
    double offset;           // normal * (p - camera) + offset >= 0 inside.
  };

  Eigen::Vector3d position_;
  std::array<Plane, 6> planes_;
};

/// Tiles, from lowest to highest index on each axis, both included.
struct TileRange {
  Index3 min{};
  Index3 max{};
};

/// The tiles a box touches, cut at the grid's border; of a box off the cube the nearest tiles.
TileRange tiles_of(const Grid& grid, const Box& box);

/// How far the nearest point of a box is from a point; 0 inside.
double distance(const Box& box, const Eigen::Vector3d& p_ecef);

/// Those of `keys` that the camera may see, nearest first; equal distances in order of key.
std::vector<TileKey> tiles_in_view(const Camera& camera, const Grid& grid,
                                   std::span<const TileKey> keys);

}  // namespace voxatlas
