#pragma once

#include <Eigen/Core>

#include "sim/solid.hpp"

namespace voxatlas {

/// The ground of the city: a tilted plane of streets, with blocks that stand a curb above it.
///
/// Frame:  the city's: x and y along the streets, z up (plumb), metres. Streets cross at multiples
///         of kPitch; kBlocks x kBlocks blocks lie between and around them; beyond is meadow, at
///         the streets' level.
class Ground {
 public:
  static constexpr double kPitch = 75;                          ///< From street to street.
  static constexpr int kBlocks = 8;                             ///< An axis.
  static constexpr double kHalfRoad = 8;                        ///< Half a carriageway's width.
  static constexpr double kHalfBlock = kPitch / 2 - kHalfRoad;  ///< To the curb.
  static constexpr double kCurb = 0.12;                         ///< A block above the street.
  static constexpr double kSlopeX = 0.02, kSlopeY = -0.012;

  struct Hit {
    double t = kNoHit;
    Material material = Material::kAsphalt;
    Rgb colour;
  };

  /// Height of the streets' plane, and of what one walks on.
  static double plane(double x, double y) { return kSlopeX * x + kSlopeY * y; }
  static double height(double x, double y) { return plane(x, y) + (on_block(x, y) ? kCurb : 0); }
  static bool on_block(double x, double y);
  static double block_centre(int index) { return (index - (kBlocks - 1) / 2.0) * kPitch; }
  /// A block whose ground is grass: the ring around the city, and parks in it.
  static bool is_park(int column, int row);
  static Eigen::Vector3d normal();  ///< Of the plane, length 1.

  /// Where a beam from above meets the ground before `limit`.
  static Hit first_hit(const Beam& beam, double limit);

  /// Distance to the ground's surface, negative below it; within a curb's height of a block's
  /// corner it may be 2 % off, elsewhere it is exact.
  static double signed_distance(const Eigen::Vector3d& p);

  /// What lies at a place.
  static Hit look(double x, double y);
};

}  // namespace voxatlas
