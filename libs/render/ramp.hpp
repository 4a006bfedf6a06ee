#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

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

/// Either of these in steps, so that a cell costs a look instead of a root.
class HeightColours {
 public:
  /// `rise`: the scene's height, metres.
  HeightColours(Rgb (*colour)(double), double rise);
  Rgb at(double metres) const {
    const double step = metres > 0 ? metres * steps_per_metre_ : 0;
    return table_[static_cast<std::size_t>(std::min<double>(step, kSteps))];
  }

 private:
  static constexpr int kSteps = 1000;
  double steps_per_metre_;
  std::array<Rgb, kSteps + 1> table_{};
};

/// For heights above the ellipsoid, metres: the ramp up and down again, kEllipsoidTurn each way.
inline constexpr double kEllipsoidTurn = 50;
Rgb ellipsoid_colour(double height);

/// For the eight depths of a tile, told apart easily.
Rgb depth_colour(int depth);

}  // namespace voxatlas
