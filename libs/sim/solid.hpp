#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "octree/colour.hpp"

namespace voxatlas {

/// What a surface of the city is made of.
enum class Material : std::uint8_t {
  kAsphalt,
  kMarking,
  kPavement,
  kCurb,
  kGrass,
  kWall,
  kGlass,
  kDoor,
  kRoof,
  kTrunk,
  kLeaves,
  kPole,
  kCarBody,
  kTyre,
};

enum class Shape : std::uint8_t {
  kBox,
  kCylinder,  ///< Round about `axis`, which may be 0, 1 or 2.
  kSphere,
  kGable,  ///< A roof: the ridge runs along `axis`, 0 or 1, over the middle of the box.
};

/// A convex body, inscribed in an axis-parallel box of the city's frame.
///
/// Units: metres. A cylinder's box is square across its axis, a sphere's is a cube.
struct Solid {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  Rgb colour;
  Material material = Material::kWall;
  Shape shape = Shape::kBox;
  std::uint8_t axis = 2;
};

/// Light going out from a point: p(t) = origin + t * direction, t in metres.
struct Beam {
  /// `unit_direction` has length 1; components of zero become 1e-12, so that all have an inverse.
  Beam(const Eigen::Vector3d& from, const Eigen::Vector3d& unit_direction);

  Eigen::Vector3d at(double t) const { return origin + t * direction; }

  Eigen::Vector3d origin, direction, inverse;
};

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

/// Where a beam enters a solid: 0 when it starts inside, kNoHit when it passes by.
double entry(const Solid& solid, const Beam& beam);

/// Exact distance to a solid's surface, negative inside.
double signed_distance(const Solid& solid, const Eigen::Vector3d& p);

}  // namespace voxatlas
