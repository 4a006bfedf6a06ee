#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/random.hpp"
#include "sim/solid.hpp"

namespace voxatlas {

/// What the city is furnished with. Each function appends the solids of one thing; lengths are
/// metres in the city's frame.

/// A house of a row, on a plan rectangle: windows 20 cm deep in every floor of the sides that have
/// them, a door to the street, a gabled roof, a chimney.
struct House {
  enum Side : std::uint8_t { kWest, kEast, kSouth, kNorth };

  Eigen::Vector2d min, max;
  int floors = 4;
  std::uint8_t ridge_axis = 0;
  std::array<bool, 4> windows{};  ///< By Side; the others are blank walls.
  Side street = kSouth;           ///< Where the door is.
};
inline constexpr double kWindowDepth = 0.2;

void add_house(std::vector<Solid>& solids, const House& house, Draw draw);

void add_tree(std::vector<Solid>& solids, double x, double y, Draw draw);

/// A lamp whose arm reaches towards (dx, dy), a unit vector along an axis.
void add_lamp(std::vector<Solid>& solids, double x, double y, double dx, double dy);

/// A thin post with a round sign that faces along `axis`.
void add_sign(std::vector<Solid>& solids, double x, double y, std::uint8_t axis);

void add_bench(std::vector<Solid>& solids, double x, double y);

/// A car, van or bus, standing or driving along an axis.
struct Vehicle {
  enum Kind : std::uint8_t { kCar, kVan, kBus };

  Kind kind = kCar;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  std::uint8_t axis = 0;
  Rgb colour;

  Eigen::Vector2d half_size() const;  ///< On x and y.
};

Vehicle draw_vehicle(Draw draw, bool parked);
void add_vehicle(std::vector<Solid>& solids, const Vehicle& vehicle);

/// A box, the most frequent solid.
Solid make_box(const Eigen::Vector3d& min, const Eigen::Vector3d& max, Material material,
               Rgb colour);

}  // namespace voxatlas
