#include "sim/things.hpp"

#include <cmath>

#include "sim/ground.hpp"

namespace voxatlas {
namespace {

constexpr Rgb kBark{98, 72, 48}, kSteel{112, 116, 120}, kLampHead{210, 206, 180};
constexpr Rgb kSignRed{196, 40, 36}, kWood{134, 98, 62}, kTyreBlack{28, 28, 30};
constexpr Rgb kCarGlass{54, 66, 82}, kBusYellow{216, 176, 40};
constexpr std::array<Rgb, 9> kPaints{{{188, 26, 30},
                                      {28, 60, 130},
                                      {214, 214, 216},
                                      {40, 42, 46},
                                      {130, 134, 140},
                                      {26, 92, 60},
                                      {196, 188, 160},
                                      {230, 150, 30},
                                      {92, 20, 40}}};

Solid make_sphere(const Eigen::Vector3d& centre, double radius, Material material, Rgb colour) {
  Solid sphere = make_box(centre.array() - radius, centre.array() + radius, material, colour);
  sphere.shape = Shape::kSphere;
  return sphere;
}

Solid make_post(double x, double y, double low, double high, double radius, Material material,
                Rgb colour) {
  Solid post =
      make_box({x - radius, y - radius, low}, {x + radius, y + radius, high}, material, colour);
  post.shape = Shape::kCylinder;
  return post;
}

/// Where a thing's foot stands: a little in the ground, which is tilted.
double foot(double x, double y) { return Ground::height(x, y) - 0.05; }

struct Body {
  double length, width, floor, waist, top;  // Metres above the ground, but for the first two.
  double cabin_rear, cabin_front;           // Of the part above the waist, from the centre.
};

Body body_of(Vehicle::Kind kind) {
  switch (kind) {
    case Vehicle::kVan:
      return {5.4, 2.0, 0.3, 1.2, 2.3, -2.6, 1.7};
    case Vehicle::kBus:
      return {11.5, 2.5, 0.35, 1.3, 3.0, -5.7, 5.7};
    case Vehicle::kCar:
      break;
  }
  return {4.4, 1.8, 0.25, 0.88, 1.46, -1.5, 0.9};
}

}  // namespace

Solid make_box(const Eigen::Vector3d& min, const Eigen::Vector3d& max, Material material,
               Rgb colour) {
  Solid box;
  box.min = min;
  box.max = max;
  box.material = material;
  box.colour = colour;
  return box;
}

void add_tree(std::vector<Solid>& solids, double x, double y, Draw draw) {
  const double low = foot(x, y), crown = low + draw.between(3.0, 4.2);
  solids.push_back(make_post(x, y, low, crown, draw.between(0.12, 0.22), Material::kTrunk, kBark));
  const auto green = [&draw](double shade) {
    return Rgb{static_cast<std::uint8_t>(shade * draw.between(44, 92)),
               static_cast<std::uint8_t>(shade * draw.between(104, 148)),
               static_cast<std::uint8_t>(shade * draw.between(34, 60))};
  };
  const double size = draw.between(1.2, 1.6);
  solids.push_back(make_sphere({x, y, crown + 0.8 * size}, size, Material::kLeaves, green(1)));
  const double turn = draw.between(0, 6.283);
  for (int i = 0; i < 5; ++i) {
    const double angle = turn + 1.2566 * i, radius = draw.between(0.65, 0.9) * size;
    const Eigen::Vector3d centre(x + 0.8 * size * std::cos(angle), y + 0.8 * size * std::sin(angle),
                                 crown + draw.between(0.3, 1.3) * size);
    solids.push_back(make_sphere(centre, radius, Material::kLeaves, green(draw.between(0.8, 1.1))));
  }
}

void add_lamp(std::vector<Solid>& solids, double x, double y, double dx, double dy) {
  const double low = foot(x, y), top = low + 7;
  solids.push_back(make_post(x, y, low, top, 0.08, Material::kPole, kSteel));
  const Eigen::Vector3d near(x, y, top), far(x + 1.8 * dx, y + 1.8 * dy, top);
  const Eigen::Vector3d thick(0.05, 0.05, 0.05), head(0.22, 0.22, 0.1);
  solids.push_back(
      make_box(near.cwiseMin(far) - thick, near.cwiseMax(far) + thick, Material::kPole, kSteel));
  solids.push_back(make_box(far - head, far + head, Material::kPole, kLampHead));
}

void add_sign(std::vector<Solid>& solids, double x, double y, std::uint8_t axis) {
  const double low = foot(x, y);
  solids.push_back(make_post(x, y, low, low + 2.9, 0.04, Material::kPole, kSteel));
  Eigen::Vector3d half(0.35, 0.35, 0.35);
  half[axis] = 0.05;
  const Eigen::Vector3d centre(x, y, low + 2.6);
  Solid disc = make_box(centre - half, centre + half, Material::kPole, kSignRed);
  disc.shape = Shape::kCylinder;
  disc.axis = axis;
  solids.push_back(disc);
}

void add_bench(std::vector<Solid>& solids, double x, double y) {
  const double low = foot(x, y);
  solids.push_back(make_box({x - 0.9, y - 0.25, low + 0.4}, {x + 0.9, y + 0.25, low + 0.5},
                            Material::kTrunk, kWood));
  solids.push_back(make_box({x - 0.9, y + 0.2, low + 0.5}, {x + 0.9, y + 0.27, low + 0.95},
                            Material::kTrunk, kWood));
  for (const double leg : {-0.75, 0.65}) {
    solids.push_back(make_box({x + leg, y - 0.2, low}, {x + leg + 0.1, y + 0.2, low + 0.4},
                              Material::kPole, kSteel));
  }
}

Eigen::Vector2d Vehicle::half_size() const {
  const Body body = body_of(kind);
  Eigen::Vector2d half(body.length / 2, body.width / 2);
  return axis == 0 ? half : Eigen::Vector2d(half.reverse());
}

Vehicle draw_vehicle(Draw draw, bool parked) {
  Vehicle vehicle;
  const double kind = draw.unit();
  vehicle.kind = kind < 0.8 ? Vehicle::kCar : kind < 0.93 || parked ? Vehicle::kVan : Vehicle::kBus;
  vehicle.colour = vehicle.kind == Vehicle::kBus
                       ? kBusYellow
                       : kPaints[static_cast<std::size_t>(draw.below(kPaints.size()))];
  return vehicle;
}

void add_vehicle(std::vector<Solid>& solids, const Vehicle& vehicle) {
  const Body body = body_of(vehicle.kind);
  const double ground = Ground::height(vehicle.centre.x(), vehicle.centre.y());
  const auto part = [&](double rear, double front, double half_width, double middle, double low,
                        double high, Material material, Rgb colour) {
    Eigen::Vector3d min, max;
    min[vehicle.axis] = vehicle.centre[vehicle.axis] + rear;
    max[vehicle.axis] = vehicle.centre[vehicle.axis] + front;
    min[1 - vehicle.axis] = vehicle.centre[1 - vehicle.axis] + middle - half_width;
    max[1 - vehicle.axis] = vehicle.centre[1 - vehicle.axis] + middle + half_width;
    min.z() = ground + low;
    max.z() = ground + high;
    return make_box(min, max, material, colour);
  };
  const double half = body.width / 2, reach = body.length / 2;
  solids.push_back(
      part(-reach, reach, half, 0, body.floor, body.waist, Material::kCarBody, vehicle.colour));
  solids.push_back(part(body.cabin_rear, body.cabin_front, half - 0.12, 0, body.waist, body.top,
                        Material::kGlass, kCarGlass));
  solids.push_back(part(body.cabin_rear, body.cabin_front, half - 0.1, 0, body.top, body.top + 0.06,
                        Material::kCarBody, vehicle.colour));
  for (const double along : {-0.62 * reach, 0.62 * reach}) {
    for (const double side : {-1.0, 1.0}) {
      Solid wheel = part(along - 0.32, along + 0.32, 0.1, side * (half - 0.1), 0, 0.64,
                         Material::kTyre, kTyreBlack);
      wheel.shape = Shape::kCylinder;
      wheel.axis = static_cast<std::uint8_t>(1 - vehicle.axis);
      solids.push_back(wheel);
    }
  }
}

}  // namespace voxatlas
