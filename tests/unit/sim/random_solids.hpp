#pragma once

#include <Eigen/Core>
#include <random>

#include "sim/solid.hpp"

namespace voxatlas::test {

inline double between(std::mt19937_64& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

inline Eigen::Vector3d point_in(std::mt19937_64& rng, double half) {
  return {between(rng, -half, half), between(rng, -half, half), between(rng, -half, half)};
}

inline Eigen::Vector3d unit_vector(std::mt19937_64& rng) {
  Eigen::Vector3d v;
  do {
    v = point_in(rng, 1);
  } while (v.norm() > 1 || v.norm() < 0.1);
  return v.normalized();
}

/// One of each shape in turn, about a metre in size, within `half` of the origin.
inline Solid any_solid(std::mt19937_64& rng, int number, double half) {
  Solid solid;
  solid.shape = static_cast<Shape>(number % 4);
  const Eigen::Vector3d centre = point_in(rng, half);
  Eigen::Vector3d size(between(rng, 0.05, 2), between(rng, 0.05, 2), between(rng, 0.05, 2));
  solid.axis = static_cast<std::uint8_t>(rng() % (solid.shape == Shape::kGable ? 2 : 3));
  if (solid.shape == Shape::kSphere) size.setConstant(size.x());
  if (solid.shape == Shape::kCylinder) {
    size[(solid.axis + 1) % 3] = size[(solid.axis + 2) % 3];
  }
  solid.min = centre - size / 2;
  solid.max = centre + size / 2;
  return solid;
}

/// Whether a point lies in a solid, straight from what each shape is.
inline bool holds(const Solid& solid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d centre = (solid.min + solid.max) / 2, size = solid.max - solid.min;
  if ((p.array() < solid.min.array()).any() || (p.array() > solid.max.array()).any()) return false;
  const Eigen::Vector3d q = 2 * (p - centre).cwiseQuotient(size);  // The box is [-1, 1] cubed.
  const int u = (solid.axis + 1) % 3, v = (solid.axis + 2) % 3;
  switch (solid.shape) {
    case Shape::kCylinder:
      return q[u] * q[u] + q[v] * q[v] <= 1;
    case Shape::kSphere:
      return q.squaredNorm() <= 1;
    case Shape::kGable:
      return std::abs(q[1 - solid.axis]) <= (1 - q.z()) / 2;
    case Shape::kBox:
      break;
  }
  return true;
}

}  // namespace voxatlas::test
