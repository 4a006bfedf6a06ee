#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "octree/colour.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"

namespace voxatlas {

/// A line on the picture, in pixels from its upper left corner.
struct Stroke {
  Eigen::Vector2f from, to;
  Rgb colour;
};
using Strokes = std::vector<Stroke>;

/// Adds a text of digits, '.', ' ', and the letters N, m, x, y, z; others are left out. `corner` is
/// its lower left, `height` that of its letters, pixels. Returns how wide it is.
float add_text(Strokes& strokes, const std::string& text, const Eigen::Vector2f& corner,
               float height, Rgb colour);

/// ECEF's axes x (red), y (green) and z (blue) as the camera sees them, at the lower left.
Strokes axes_sign(const Camera& camera);

/// An arrow to the north, as it lies on the ground below the camera, at the upper right.
Strokes north_sign(const Camera& camera);

/// A bar of a round length at the lower right, and what it is. A map's scale holds everywhere, a
/// view's at the distance that the middle of the picture shows, which the sign tells, too.
Strokes scale_sign(const Camera& camera, const CellImage& cells);

/// 1, 2 or 5 times a power of ten: the longest that is not above `limit`, which is positive.
double round_length(double limit);

}  // namespace voxatlas
