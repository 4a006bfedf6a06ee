#pragma once

#include "octree/colour.hpp"

namespace voxatlas {

/// A ramp of colours that grows evenly lighter, from dark blue over green to light yellow, so that
/// equal steps of the value look equal, in grey and to the colour-blind too.
/// `t` outside 0..1 is held to it.
Rgb ramp_colour(double t);

/// For heights above ground in metres, 0..25 and beyond: the lower metres, where cars and people
/// are, get most of the ramp (its square root).
Rgb height_colour(double metres_above_ground);

/// What has no colour of its own: grey, lighter with height.
Rgb neutral_colour(double metres_above_ground);

/// For the eight depths of a tile, told apart easily.
Rgb depth_colour(int depth);

}  // namespace voxatlas
