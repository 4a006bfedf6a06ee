#include <algorithm>
#include <cmath>

#include "sim/ground.hpp"
#include "sim/things.hpp"

namespace voxatlas {
namespace {

constexpr double kFloor = 3.2, kSill = 0.9, kWindowWidth = 1.35, kWindowHeight = 1.6, kBay = 2.7;
constexpr double kDoorRecess = 0.1, kOverhang = 0.35;

constexpr std::array<Rgb, 8> kWalls{{{214, 198, 160},
                                     {196, 146, 110},
                                     {222, 214, 200},
                                     {178, 96, 78},
                                     {168, 178, 166},
                                     {226, 190, 120},
                                     {190, 170, 176},
                                     {150, 152, 158}}};
constexpr std::array<Rgb, 4> kRoofs{{{158, 62, 46}, {142, 54, 44}, {172, 78, 54}, {128, 58, 52}}};
constexpr std::array<Rgb, 3> kDoors{{{86, 52, 30}, {52, 70, 56}, {70, 40, 46}}};
constexpr Rgb kGlass{92, 118, 148}, kChimney{120, 72, 60};

/// Heights and colours that the parts of one house share.
struct Style {
  double bottom, first_floor, top;
  Rgb wall, roof, door;
};

/// One outer wall: a layer as deep as the windows, from the outer face inwards.
struct Wall {
  int normal;           // Axis across the wall.
  double inner, outer;  // On that axis.
  double from, to;      // Along the wall.
  const Style& style;

  Solid part(double a, double b, double low, double high, Material material, Rgb colour) const {
    return part_at(inner, outer, a, b, low, high, material, colour);
  }
  Solid part_at(double n0, double n1, double a, double b, double low, double high,
                Material material, Rgb colour) const {
    Eigen::Vector3d min, max;
    min[normal] = std::min(n0, n1);
    max[normal] = std::max(n0, n1);
    min[1 - normal] = a;
    max[1 - normal] = b;
    min.z() = low;
    max.z() = high;
    return make_box(min, max, material, colour);
  }
};

Wall make_wall(const House& house, House::Side side, const Style& style) {
  const int normal = side == House::kWest || side == House::kEast ? 0 : 1;
  const bool low = side == House::kWest || side == House::kSouth;
  const double outer = low ? house.min[normal] : house.max[normal];
  return {normal,
          outer + (low ? kWindowDepth : -kWindowDepth),
          outer,
          house.min[1 - normal],
          house.max[1 - normal],
          style};
}

/// What is wall over and under the windows of one bay, and the door where it has one.
void add_bay(std::vector<Solid>& solids, const Wall& wall, double left, int floors, bool door) {
  const Style& style = wall.style;
  const double right = left + kWindowWidth;
  double low = style.bottom;
  for (int floor = 0; floor < floors; ++floor) {
    const double sill = style.first_floor + floor * kFloor + kSill;
    if (door && floor == 0) {
      const double face = wall.outer + (wall.inner > wall.outer ? kDoorRecess : -kDoorRecess);
      solids.push_back(wall.part_at(wall.inner, face, left, right, style.bottom,
                                    sill + kWindowHeight, Material::kDoor, style.door));
    } else {
      solids.push_back(wall.part(left, right, low, sill, Material::kWall, style.wall));
    }
    low = sill + kWindowHeight;
  }
  solids.push_back(wall.part(left, right, low, style.top, Material::kWall, style.wall));
}

void add_facade(std::vector<Solid>& solids, const Wall& wall, int floors, bool door) {
  const double length = wall.to - wall.from;
  const int bays = std::max(1, static_cast<int>((length - 0.8) / kBay));
  double pier = wall.from;
  for (int bay = 0; bay < bays; ++bay) {
    const double left = wall.from + length * (bay + 0.5) / bays - kWindowWidth / 2;
    solids.push_back(
        wall.part(pier, left, wall.style.bottom, wall.style.top, Material::kWall, wall.style.wall));
    add_bay(solids, wall, left, floors, door && bay == bays / 2);
    pier = left + kWindowWidth;
  }
  solids.push_back(wall.part(pier, wall.to, wall.style.bottom, wall.style.top, Material::kWall,
                             wall.style.wall));
  const double ledge = wall.outer + (wall.inner > wall.outer ? -0.12 : 0.12);
  solids.push_back(wall.part_at(wall.inner, ledge, wall.from, wall.to, wall.style.top - 0.3,
                                wall.style.top, Material::kWall, wall.style.wall));
}

/// The masonry under a roof: it shows at the roof's ends, and there alone.
Solid gable_wall(const Solid& roof, const Style& style) {
  const int across = 1 - roof.axis;
  Solid wall = roof;
  wall.min[roof.axis] -= 0.04;
  wall.max[roof.axis] += 0.04;
  wall.min[across] += kOverhang;
  wall.max[across] -= kOverhang;
  const double inner = (wall.max - wall.min)[across] / (roof.max - roof.min)[across];
  wall.max.z() = roof.min.z() + inner * (roof.max - roof.min).z() - 0.12;
  wall.material = Material::kWall;
  wall.colour = style.wall;
  return wall;
}

void add_roof(std::vector<Solid>& solids, const House& house, const Style& style, Draw& draw) {
  const int across = 1 - house.ridge_axis;
  Solid roof;
  roof.shape = Shape::kGable;
  roof.axis = house.ridge_axis;
  roof.min << house.min, style.top;
  roof.max << house.max, style.top + 0.38 * (house.max - house.min)[across];
  roof.min[across] -= kOverhang;
  roof.max[across] += kOverhang;
  roof.material = Material::kRoof;
  roof.colour = style.roof;
  solids.push_back(roof);
  solids.push_back(gable_wall(roof, style));

  Eigen::Vector3d foot;
  foot[house.ridge_axis] =
      draw.between(house.min[house.ridge_axis] + 1.5, house.max[house.ridge_axis] - 2.5);
  foot[across] = (house.min[across] + house.max[across]) / 2 + 1;
  foot.z() = style.top;
  solids.push_back(make_box(foot, {foot.x() + 0.7, foot.y() + 0.7, roof.max.z() + 0.6},
                            Material::kWall, kChimney));
}

}  // namespace

void add_house(std::vector<Solid>& solids, const House& house, Draw draw) {
  double low = kNoHit, high = -kNoHit;  // Of the ground at the corners.
  for (const double x : {house.min.x(), house.max.x()}) {
    for (const double y : {house.min.y(), house.max.y()}) {
      low = std::min(low, Ground::height(x, y));
      high = std::max(high, Ground::height(x, y));
    }
  }
  const auto pick = [&draw](const auto& colours) {
    return colours[static_cast<std::size_t>(draw.below(static_cast<int>(colours.size())))];
  };
  Style style{low - 0.5,    high + 0.1,   high + 0.1 + house.floors * kFloor + 0.3,
              pick(kWalls), pick(kRoofs), pick(kDoors)};

  Eigen::Vector3d min, max;  // The core: seen through the windows, so it is glass.
  min << house.min.array() + kWindowDepth, style.bottom;
  max << house.max.array() - kWindowDepth, style.top;
  solids.push_back(make_box(min, max, Material::kGlass, kGlass));
  for (const auto side : {House::kWest, House::kEast, House::kSouth, House::kNorth}) {
    const Wall wall = make_wall(house, side, style);
    if (house.windows[side]) {
      add_facade(solids, wall, house.floors, side == house.street);
    } else {
      solids.push_back(
          wall.part(wall.from, wall.to, style.bottom, style.top, Material::kWall, style.wall));
    }
  }
  add_roof(solids, house, style, draw);
}

}  // namespace voxatlas
