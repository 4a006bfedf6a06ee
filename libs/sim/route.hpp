#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace voxatlas {

/// A way through the streets, as long as is asked for: on the inner right-hand lane, round corners
/// in arcs, at each crossing into the street that it has driven least.
///
/// Frame: the city's plan. Units: metres along the way; radians, counter-clockwise from x.
class Route {
 public:
  static constexpr double kLane = 1.45;  ///< Right of the street's middle.

  struct Place {
    Eigen::Vector2d p;
    double heading;
  };

  Route(std::uint64_t seed, double length);

  /// From the start to `length`; what is beyond is held at the end.
  Place at(double along) const;

 private:
  struct Piece {
    double begin;  ///< Along the way.
    Place start;
    double curvature;  ///< 1 / radius, positive to the left; 0: straight.
  };

  void add(double length, double curvature);

  std::vector<Piece> pieces_;
  double end_ = 0;
  Place tip_;
};

}  // namespace voxatlas
