#include "sim/solid.hpp"

#include <algorithm>
#include <cmath>

namespace voxatlas {
namespace {

/// The part of a beam that lies in a convex set: empty when enter > leave.
struct Span {
  double enter = 0;
  double leave = kNoHit;

  void cut(double from, double to) {
    enter = std::max(enter, from);
    leave = std::min(leave, to);
  }
  void cut_slab(double t0, double t1) { cut(std::min(t0, t1), std::max(t0, t1)); }
  /// Keeps where a + b t <= 0.
  void cut_half_space(double a, double b) {
    if (b > 0) {
      leave = std::min(leave, -a / b);
    } else if (b < 0) {
      enter = std::max(enter, -a / b);
    } else if (a > 0) {
      leave = -kNoHit;
    }
  }
  /// Keeps where a t^2 + 2 b t + c <= 0, a > 0.
  void cut_quadric(double a, double b, double c) {
    const double root = b * b - a * c;
    if (root < 0) {
      leave = -kNoHit;
    } else {
      const double half = std::sqrt(root);
      cut((-b - half) / a, (-b + half) / a);
    }
  }
  double result() const { return enter <= leave ? enter : kNoHit; }
};

void cut_axis(Span& span, const Solid& solid, const Beam& beam, int axis) {
  span.cut_slab((solid.min[axis] - beam.origin[axis]) * beam.inverse[axis],
                (solid.max[axis] - beam.origin[axis]) * beam.inverse[axis]);
}

double cylinder_entry(const Solid& solid, const Beam& beam) {
  Span span;
  cut_axis(span, solid, beam, solid.axis);
  const int u = (solid.axis + 1) % 3, v = (solid.axis + 2) % 3;
  const double radius = (solid.max[u] - solid.min[u]) / 2;
  const double pu = beam.origin[u] - (solid.min[u] + solid.max[u]) / 2;
  const double pv = beam.origin[v] - (solid.min[v] + solid.max[v]) / 2;
  const double du = beam.direction[u], dv = beam.direction[v];
  span.cut_quadric(du * du + dv * dv, pu * du + pv * dv, pu * pu + pv * pv - radius * radius);
  return span.result();
}

double sphere_entry(const Solid& solid, const Beam& beam) {
  Span span;
  const double radius = (solid.max[0] - solid.min[0]) / 2;
  const Eigen::Vector3d p = beam.origin - (solid.min + solid.max) / 2;
  span.cut_quadric(beam.direction.squaredNorm(), p.dot(beam.direction),
                   p.squaredNorm() - radius * radius);
  return span.result();
}

double gable_entry(const Solid& solid, const Beam& beam) {
  Span span;
  cut_axis(span, solid, beam, solid.axis);
  cut_axis(span, solid, beam, 2);
  const int across = 1 - solid.axis;
  const double half = (solid.max[across] - solid.min[across]) / 2;
  const double height = solid.max[2] - solid.min[2];
  const double p = (beam.origin[across] - solid.min[across]) / half - 1;
  const double d = beam.direction[across] / half;
  const double w = (beam.origin[2] - solid.min[2]) / height - 1;
  const double dw = beam.direction[2] / height;
  span.cut_half_space(w + p, dw + d);
  span.cut_half_space(w - p, dw - d);
  return span.result();
}

double box_entry(const Solid& solid, const Beam& beam) {
  Span span;
  for (int axis = 0; axis < 3; ++axis) cut_axis(span, solid, beam, axis);
  return span.result();
}

/// A set that is the product of two: the distances to each, across one another, make the whole.
double product_distance(double d1, double d2) {
  const double outside = std::hypot(std::max(d1, 0.0), std::max(d2, 0.0));
  return outside + std::min(std::max(d1, d2), 0.0);
}

double segment_distance(double u, double w, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d p(u, w), ab = b - a;
  const double along = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - along * ab).norm();
}

double gable_distance(const Solid& solid, const Eigen::Vector3d& p) {
  const int across = 1 - solid.axis;
  const double half = (solid.max[across] - solid.min[across]) / 2;
  const double height = solid.max[2] - solid.min[2];
  const double u = std::abs(p[across] - (solid.min[across] + solid.max[across]) / 2);
  const double w = p[2] - solid.min[2];
  const double away = std::min(segment_distance(u, w, {half, 0}, {0, height}),
                               segment_distance(u, w, {0, 0}, {half, 0}));
  const bool inside = w >= 0 && u / half + w / height <= 1;
  const double along =
      std::max(solid.min[solid.axis] - p[solid.axis], p[solid.axis] - solid.max[solid.axis]);
  return product_distance(inside ? -away : away, along);
}

}  // namespace

Beam::Beam(const Eigen::Vector3d& from, const Eigen::Vector3d& unit_direction)
    : origin(from), direction(unit_direction) {
  for (double& d : direction) {
    if (std::abs(d) < 1e-12) d = 1e-12;
  }
  inverse = direction.cwiseInverse();
}

double entry(const Solid& solid, const Beam& beam) {
  switch (solid.shape) {
    case Shape::kCylinder:
      return cylinder_entry(solid, beam);
    case Shape::kSphere:
      return sphere_entry(solid, beam);
    case Shape::kGable:
      return gable_entry(solid, beam);
    case Shape::kBox:
      break;
  }
  return box_entry(solid, beam);
}

double signed_distance(const Solid& solid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d centre = (solid.min + solid.max) / 2;
  const Eigen::Vector3d beyond = (p - centre).cwiseAbs() - (solid.max - solid.min) / 2;
  const int u = (solid.axis + 1) % 3, v = (solid.axis + 2) % 3;
  switch (solid.shape) {
    case Shape::kCylinder:
      return product_distance(
          std::hypot(p[u] - centre[u], p[v] - centre[v]) - (solid.max[u] - solid.min[u]) / 2,
          beyond[solid.axis]);
    case Shape::kSphere:
      return (p - centre).norm() - (solid.max[0] - solid.min[0]) / 2;
    case Shape::kGable:
      return gable_distance(solid, p);
    case Shape::kBox:
      break;
  }
  return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

}  // namespace voxatlas
