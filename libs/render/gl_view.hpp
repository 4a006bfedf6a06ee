#pragma once

#include <Eigen/Core>
#include <array>

#include "grid/grid.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// A camera in OpenGL's terms; without any call of it.

/// Camera coordinates to GL's cube, column by column; the picture has `margin` pixels more on each
/// side.
std::array<double, 16> gl_projection(const Lens& lens, int margin);

/// Camera coordinates of a place in a tile, counted from its lower corner in parts of a voxel:
/// `parts` of them to its edge. Exact in float on any place on Earth where parts are whole.
Eigen::Matrix4d camera_from_tile(const Camera& camera, const Grid& grid, TileKey key, int parts);

/// A depth of GL's window, 0 near .. 1 far, from metres along the camera's axis, and back.
double gl_depth_of(double metres, const Lens& lens);
double metres_of_gl_depth(double depth, const Lens& lens);

}  // namespace voxatlas
