#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "geodesy/enu_frame.hpp"
#include "grid/grid.hpp"
#include "render/cell_cloud.hpp"

namespace voxatlas {

/// A plan of a place, seen as someone who wants to stand and look there: where the ground is, and
/// what is in the way.
///
/// Frame: `frame`'s east and north; squares of kSquare, kHalf of them to each side.
class StreetMap {
 public:
  static constexpr double kSquare = 0.5;  ///< Metres.
  static constexpr double kReach = 48;    ///< Metres from the middle to each side.

  StreetMap(const EnuFrame& frame, const Grid& grid, std::span<const PlacedCloud> clouds);

  /// Height of the ground around a place in `frame`; nullopt where too little is known.
  std::optional<double> ground(const Eigen::Vector2d& p) const;
  /// Something stands between knee and twice a person's height within `radius` of p.
  bool blocked(const Eigen::Vector2d& p, double radius) const;
  /// Metres from p towards `direction` (length 1) until something is in the way, or nothing is
  /// known any more; at most `limit`.
  double clear_way(const Eigen::Vector2d& p, const Eigen::Vector2d& direction, double limit) const;
  /// How much there is to see from `eye` towards `direction`: the share of a picture, 80 degrees
  /// wide, that shows something at 4 to 60 m; above the horizon it counts twice.
  double outlook(const Eigen::Vector3d& eye, const Eigen::Vector2d& direction) const;

 private:
  struct Square {
    int x, y;
  };
  static Square square_of(const Eigen::Vector2d& p, double edge);

  std::vector<Eigen::Vector3f> cells_;  // In the frame.
  std::vector<float> ground_;           // Of each block; NaN where unknown.
  std::vector<bool> blocked_;           // Of each square.
};

}  // namespace voxatlas
