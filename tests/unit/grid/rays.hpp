#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "grid/walk.hpp"

namespace voxatlas::test {

/// A segment in voxels, as Walk takes it.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d end;
};

/// The cells a walk visits, the first included.
inline std::vector<Eigen::Vector3i> cells_of(const Ray& ray, int shift) {
  Walk walk(ray.origin, ray.end, shift);
  std::vector<Eigen::Vector3i> cells{walk.cell()};
  while (walk.remaining() > 0) {
    walk.step();
    cells.push_back(walk.cell());
  }
  return cells;
}

/// One coordinate: whole, half, a multiple of 2^-16, any double, or a hair beside a whole one.
inline double any_coordinate(std::mt19937_64& rng, double low, double width) {
  const double x = low + width * std::uniform_real_distribution<double>(0, 1)(rng);
  switch (rng() % 6) {
    case 0:
    case 1:
      return std::floor(x);
    case 2:
      return std::floor(x) + 0.5;
    case 3:
      return std::floor(x * 65536) / 65536;
    case 4:
      return std::nextafter(std::ceil(x), rng() % 2 == 0 ? 0 : 1e9);
    default:
      return x;
  }
}

/// A ray of at most `width` voxels an axis, anywhere on the grid; one in four is parallel to one
/// or two axes, or has no length, one in eight is diagonal, so that it ties at every step.
inline Ray any_ray(std::mt19937_64& rng, double width) {
  Ray ray;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = rng() % 4 == 0 ? 0 : static_cast<double>(rng() % 250'000'000);
    ray.origin[axis] = any_coordinate(rng, low, width);
    ray.end[axis] = any_coordinate(rng, low, width);
    if (rng() % 8 == 0) ray.end[axis] = ray.origin[axis];
  }
  if (rng() % 8 == 0) {
    const double length = std::floor(width * std::uniform_real_distribution<double>(0, 1)(rng));
    ray.end = ray.origin.array() + length;
    if (rng() % 2 == 0) std::swap(ray.origin, ray.end);
  }
  return ray;
}

}  // namespace voxatlas::test
