#include "sim/ground.hpp"

#include <algorithm>
#include <cmath>

namespace voxatlas {
namespace {

constexpr Rgb kAsphaltGrey{62, 62, 66}, kParkingGrey{78, 76, 74}, kWhite{225, 225, 220};
constexpr Rgb kPavementGrey{150, 146, 140}, kCurbGrey{178, 176, 170};
constexpr Rgb kLawn{92, 128, 58}, kMeadow{112, 134, 70};

/// The block whose square of kPitch a coordinate lies in; may be outside 0 .. kBlocks - 1.
int block_of(double x) {
  return static_cast<int>(std::floor(x / Ground::kPitch + Ground::kBlocks / 2.0));
}

bool is_block(int index) { return index >= 0 && index < Ground::kBlocks; }

/// From the middle of the nearest street, and along it from the nearest crossing.
double from_street(double x) { return x - Ground::kPitch * std::round(x / Ground::kPitch); }

bool is_dash(double along, double period) {
  return along - period * std::floor(along / period) < period / 2;
}

/// Paint on a street that runs along `along`, `across` from its middle.
bool is_marked(double across, double along) {
  const double off = std::abs(across), crossing = std::abs(from_street(along));
  if (crossing < Ground::kHalfRoad) return false;
  if (crossing > 9 && crossing < 12) return off < 7.5 && is_dash(across, 1.0);  // Zebra.
  if (crossing > 13 && crossing < 13.4) return off < 5.8;
  if (crossing < 14) return false;
  return off < 0.08 || (std::abs(off - 2.9) < 0.08 && is_dash(along, 6)) ||
         std::abs(off - 5.8) < 0.06;
}

Ground::Hit look_at_road(double x, double y) {
  const double across_x = from_street(x), across_y = from_street(y);
  const bool runs_along_y = std::abs(across_x) < Ground::kHalfRoad;
  const bool runs_along_x = std::abs(across_y) < Ground::kHalfRoad;
  constexpr double kHalfCity = Ground::kPitch * Ground::kBlocks / 2;
  const bool beyond = std::max(std::abs(x), std::abs(y)) > kHalfCity;
  if (beyond || (!runs_along_x && !runs_along_y)) return {0, Material::kGrass, kMeadow};
  if ((runs_along_y && is_marked(across_x, y)) || (runs_along_x && is_marked(across_y, x))) {
    return {0, Material::kMarking, kWhite};
  }
  const double off = runs_along_y ? std::abs(across_x) : std::abs(across_y);
  const bool parking = runs_along_x != runs_along_y && off > 5.8;
  return {0, Material::kAsphalt, parking ? kParkingGrey : kAsphaltGrey};
}

/// Where the way of a beam over the plan enters a square: t, or kNoHit.
double square_entry(const Beam& beam, int column, int row, double from, double to) {
  const double centre[2] = {Ground::block_centre(column), Ground::block_centre(row)};
  for (int axis = 0; axis < 2; ++axis) {
    const double t0 = (centre[axis] - Ground::kHalfBlock - beam.origin[axis]) * beam.inverse[axis];
    const double t1 = (centre[axis] + Ground::kHalfBlock - beam.origin[axis]) * beam.inverse[axis];
    from = std::max(from, std::min(t0, t1));
    to = std::min(to, std::max(t0, t1));
  }
  return from <= to ? from : kNoHit;
}

/// The first block that a beam runs into, or down onto, between `from` and `to`.
double block_entry(const Beam& beam, double from, double to) {
  const Eigen::Vector3d a = beam.at(from), b = beam.at(to);
  double first = kNoHit;
  for (int row = block_of(std::min(a.y(), b.y())); row <= block_of(std::max(a.y(), b.y())); ++row) {
    for (int column = block_of(std::min(a.x(), b.x())); column <= block_of(std::max(a.x(), b.x()));
         ++column) {
      if (!is_block(row) || !is_block(column)) continue;
      first = std::min(first, square_entry(beam, column, row, from, to));
    }
  }
  return first;
}

/// Distance to the curb of a block along its side at `side` on `axis`.
double curb_distance(const Eigen::Vector3d& p, int column, int row, int axis, double side) {
  const double centre = axis == 0 ? Ground::block_centre(row) : Ground::block_centre(column);
  const double at = axis == 0 ? p.y() : p.x();
  const double along = std::clamp(at, centre - Ground::kHalfBlock, centre + Ground::kHalfBlock);
  const double foot = axis == 0 ? Ground::plane(side, along) : Ground::plane(along, side);
  const double up = std::clamp(p.z(), foot, foot + Ground::kCurb);
  return Eigen::Vector3d(p[axis] - side, at - along, p.z() - up).norm();
}

}  // namespace

bool Ground::on_block(double x, double y) {
  const int column = block_of(x), row = block_of(y);
  return is_block(column) && is_block(row) && std::abs(x - block_centre(column)) <= kHalfBlock &&
         std::abs(y - block_centre(row)) <= kHalfBlock;
}

bool Ground::is_park(int column, int row) {
  const bool ring = column == 0 || row == 0 || column == kBlocks - 1 || row == kBlocks - 1;
  return ring || (column * 3 + row * 5) % 11 == 7;
}

Eigen::Vector3d Ground::normal() { return Eigen::Vector3d(-kSlopeX, -kSlopeY, 1).normalized(); }

Ground::Hit Ground::look(double x, double y) {
  if (!on_block(x, y)) return look_at_road(x, y);
  const int column = block_of(x), row = block_of(y);
  const double inset =
      kHalfBlock - std::max(std::abs(x - block_centre(column)), std::abs(y - block_centre(row)));
  if (inset < 0.15) return {0, Material::kCurb, kCurbGrey};
  const bool lawn = inset > 14 || (is_park(column, row) && inset > 3);
  return lawn ? Hit{0, Material::kGrass, kLawn} : Hit{0, Material::kPavement, kPavementGrey};
}

Ground::Hit Ground::first_hit(const Beam& beam, double limit) {
  // Above the street's plane by a + b t.
  const double a = beam.origin.z() - plane(beam.origin.x(), beam.origin.y());
  const double b = beam.direction.z() - plane(beam.direction.x(), beam.direction.y());
  const double to_road = b < 0 ? -a / b : kNoHit;
  const double to_curb = (kCurb - a) / b;  // Where it passes the height of the curbs.
  const double low = b < 0 ? std::max(to_curb, 0.0) : 0.0;
  const double high = std::min(b < 0 ? to_road : to_curb, limit);
  const double block = low <= high ? block_entry(beam, low, high) : kNoHit;
  const double t = std::max(std::min(block, to_road), 0.0);
  if (t >= limit) return {};
  const Eigen::Vector3d p = beam.at(t);
  if (block == kNoHit || block == to_road) {
    Hit road = look_at_road(p.x(), p.y());
    road.t = t;
    return road;
  }
  if (block > low) return {t, Material::kCurb, kCurbGrey};
  Hit top = look(p.x(), p.y());
  top.t = t;
  return top;
}

double Ground::signed_distance(const Eigen::Vector3d& p) {
  const double upright = normal().z();
  const double above = p.z() - plane(p.x(), p.y());
  // Feet of the perpendiculars on both planes: they count where that plane is the surface.
  const Eigen::Vector3d on_road = p - normal() * (above * upright);
  const Eigen::Vector3d on_top = p - normal() * ((above - kCurb) * upright);
  double distance = kNoHit;
  if (!on_block(on_road.x(), on_road.y())) distance = std::abs(above) * upright;
  if (on_block(on_top.x(), on_top.y())) {
    distance = std::min(distance, std::abs(above - kCurb) * upright);
  }
  const int column = block_of(p.x()), row = block_of(p.y());
  if (is_block(column) && is_block(row)) {
    for (const double sign : {-1.0, 1.0}) {
      const double x = block_centre(column) + sign * kHalfBlock;
      const double y = block_centre(row) + sign * kHalfBlock;
      distance = std::min(
          {distance, curb_distance(p, column, row, 0, x), curb_distance(p, column, row, 1, y)});
    }
  }
  return p.z() < height(p.x(), p.y()) ? -distance : distance;
}

}  // namespace voxatlas
