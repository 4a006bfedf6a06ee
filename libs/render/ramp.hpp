#pragma once

#include "octree/colour.hpp"

namespace voxatlas {

/// A ramp of colours that grows evenly lighter, from dark blue over green to light yellow, so that
/// equal steps of the value look equal, in grey and to the colour-blind too.
/// `t` outside 0..1 is held to it.
Rgb ramp_colour(double t);

/// For heights above ground, as a part of the scene's own height: the lower metres, where cars and
/// people are, get most of the ramp (its square root).
Rgb height_colour(double part_of_height);

/// What has no colour of its own: slate on the ground, ochre as high as cars are, cream above.
Rgb neutral_colour(double part_of_height);

/// For the eight depths of a tile, told apart easily.
Rgb depth_colour(int depth);

}  // namespace voxatlas
