#include "sim/city_plan.hpp"

#include <cmath>

#include "sim/ground.hpp"

namespace voxatlas {
namespace {

constexpr double kHalfRow = Ground::kHalfBlock - 3;  // To the facades: the pavement is 3 m wide.
constexpr double kHouseDepth = 11;
constexpr double kHalfCity = Ground::kPitch * Ground::kBlocks / 2;
constexpr int kStreets = Ground::kBlocks - 1;
constexpr double kParkedOffset = 6.9, kTrafficOffset = 4.35, kSlotLength = 6.2;
constexpr int kSlots = 7;  // A block's side; clear of the crossings.

// The names of draws: what is drawn for one never shifts another.
enum Topic : std::uint64_t { kHouses = 1, kRow, kTrees, kYard, kParking, kLanes, kTurns };

std::uint64_t id(int number) { return static_cast<std::uint64_t>(number); }

double street(int index) { return (index - (kStreets - 1) / 2.0) * Ground::kPitch; }

struct Block {
  std::uint64_t seed;
  int column, row;
  double x, y;

  template <class... Parts>
  Draw draw(Topic topic, Parts... parts) const {
    return Draw{seed, topic, id(column), id(row), id(parts)...};
  }
};

/// A row of houses along one side of a block.
void add_row(std::vector<Solid>& solids, const Block& block, House::Side side) {
  const bool along_x = side == House::kSouth || side == House::kNorth;
  const int count = along_x ? 4 : 2, along = along_x ? 0 : 1, across = 1 - along;
  const double half = along_x ? kHalfRow : kHalfRow - kHouseDepth;
  const double sign = side == House::kSouth || side == House::kWest ? -1 : 1;
  const Eigen::Vector2d centre(block.x, block.y);
  Draw cuts = block.draw(kRow, static_cast<int>(side));
  double from = -half;
  for (int i = 0; i < count; ++i) {
    const double even = -half + 2 * half * (i + 1) / count;
    const double to = i + 1 == count ? half : even + cuts.between(-1.5, 1.5);
    House house;
    house.min[along] = centre[along] + from;
    house.max[along] = centre[along] + to;
    house.min[across] = centre[across] + (sign < 0 ? -kHalfRow : kHalfRow - kHouseDepth);
    house.max[across] = house.min[across] + kHouseDepth;
    house.floors = 3 + cuts.below(3);
    house.ridge_axis = static_cast<std::uint8_t>(along);
    house.street = side;
    const bool low_end = along_x && i == 0, high_end = along_x && i + 1 == count;
    house.windows = along_x ? std::array<bool, 4>{low_end, high_end, true, true}
                            : std::array<bool, 4>{true, true, false, false};
    const bool gap = !along_x && cuts.chance(0.25);  // A way into the yard.
    if (!gap) add_house(solids, house, block.draw(kHouses, static_cast<int>(side), i));
    from = to;
  }
}

/// Trees, lamps and signs along the curbs of a block.
void add_curb_things(std::vector<Solid>& solids, const Block& block) {
  const double curb = Ground::kHalfBlock - 0.8;
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? -1 : 1;
    const bool along_x = side < 2;
    const auto x = [&](double along) { return block.x + (along_x ? along : sign * curb); };
    const auto y = [&](double along) { return block.y + (along_x ? sign * curb : along); };
    for (int i = 0; i < 5; ++i) {
      Draw draw = block.draw(kTrees, side, i);
      const double along = -22 + 10.5 * i + draw.between(-1, 1);
      if (draw.chance(0.75)) add_tree(solids, x(along), y(along), draw);
    }
    for (const double along : {-16.5, 15.0}) {
      add_lamp(solids, x(along), y(along), along_x ? 0 : sign, along_x ? sign : 0);
    }
    const double corner = sign * 27.5;
    add_sign(solids, x(corner), y(corner), along_x ? 0 : 1);
  }
}

void add_park(std::vector<Solid>& solids, const Block& block) {
  for (int i = 0; i < 22; ++i) {
    Draw draw = block.draw(kYard, i);
    const double x = draw.between(-24, 24), y = draw.between(-24, 24);
    add_tree(solids, block.x + x, block.y + y, draw);
  }
  for (int i = 0; i < 4; ++i) {
    add_bench(solids, block.x - 15 + 10 * i, block.y - Ground::kHalfBlock + 2.2);
  }
}

void add_block(std::vector<Solid>& solids, const Block& block) {
  add_curb_things(solids, block);
  if (Ground::is_park(block.column, block.row)) {
    add_park(solids, block);
    return;
  }
  for (const auto side : {House::kSouth, House::kNorth, House::kWest, House::kEast}) {
    add_row(solids, block, side);
  }
  for (int i = 0; i < 4; ++i) {
    Draw draw = block.draw(kYard, i);
    const double x = draw.between(-11, 11), y = draw.between(-11, 11);
    add_tree(solids, block.x + x, block.y + y, draw);
  }
}

/// Who stands in a parking slot, and when.
struct Slot {
  bool taken = false;
  bool for_good = true;
  double period = 0, share = 0, phase = 0;  // Of one that comes and goes: seconds, 0..1, seconds.
  Vehicle vehicle;

  bool stands_at(double seconds) const {
    const double turns = (seconds + phase) / period;
    return turns - std::floor(turns) < share;
  }
};

Slot draw_slot(std::uint64_t seed, int axis, int street_index, int side, int block, int place) {
  Draw draw{seed, kParking, id(axis), id(street_index), id(side), id(block), id(place)};
  Slot slot;
  slot.taken = draw.chance(0.6);
  slot.for_good = draw.chance(0.85);
  slot.period = draw.between(60, 400);
  slot.share = draw.between(0.3, 0.7);
  slot.phase = draw.between(0, 400);
  slot.vehicle = draw_vehicle(draw, true);
  slot.vehicle.axis = static_cast<std::uint8_t>(axis);
  slot.vehicle.centre[axis] =
      Ground::block_centre(block) + (place - (kSlots - 1) / 2.0) * kSlotLength;
  slot.vehicle.centre[1 - axis] = street(street_index) + (side == 0 ? -1 : 1) * kParkedOffset;
  return slot;
}

template <class Visit>
void each_taken_slot(std::uint64_t seed, Visit visit) {
  for (int axis = 0; axis < 2; ++axis) {
    for (int index = 0; index < kStreets; ++index) {
      for (int side = 0; side < 2; ++side) {
        for (int block = 0; block < Ground::kBlocks; ++block) {
          for (int place = 0; place < kSlots; ++place) {
            const Slot slot = draw_slot(seed, axis, index, side, block, place);
            if (slot.taken) visit(slot);
          }
        }
      }
    }
  }
}

/// A lane's vehicles, evenly spread over the length of the city, all at one speed.
void add_lane(std::vector<Vehicle>& vehicles, std::uint64_t seed, int axis, int index,
              double direction, double seconds) {
  const std::uint64_t way = direction > 0 ? 1 : 0;
  Draw draw{seed, kLanes, id(axis), id(index), way};
  const int count = 3 + draw.below(4);
  const double speed = draw.between(6, 12), start = draw.between(0, 2 * kHalfCity);
  for (int i = 0; i < count; ++i) {
    Vehicle vehicle = draw_vehicle(Draw{seed, kTurns, id(axis), id(index), way, id(i)}, false);
    vehicle.axis = static_cast<std::uint8_t>(axis);
    const double gone = start + 2 * kHalfCity * i / count + speed * seconds;
    const double along = gone - 2 * kHalfCity * std::floor(gone / (2 * kHalfCity)) - kHalfCity;
    vehicle.centre[axis] = direction * along;
    // On the right: of +x that is -y, of +y it is +x.
    vehicle.centre[1 - axis] = street(index) + (axis == 0 ? -1 : 1) * direction * kTrafficOffset;
    vehicles.push_back(vehicle);
  }
}

}  // namespace

std::vector<Solid> plan_still(std::uint64_t seed) {
  std::vector<Solid> solids;
  for (int row = 0; row < Ground::kBlocks; ++row) {
    for (int column = 0; column < Ground::kBlocks; ++column) {
      add_block(solids,
                {seed, column, row, Ground::block_centre(column), Ground::block_centre(row)});
    }
  }
  each_taken_slot(seed, [&](const Slot& slot) {
    if (slot.for_good) add_vehicle(solids, slot.vehicle);
  });
  return solids;
}

std::vector<Vehicle> plan_traffic(std::uint64_t seed, double seconds) {
  std::vector<Vehicle> vehicles;
  for (int axis = 0; axis < 2; ++axis) {
    for (int index = 0; index < kStreets; ++index) {
      for (const double direction : {-1.0, 1.0}) {
        add_lane(vehicles, seed, axis, index, direction, seconds);
      }
    }
  }
  each_taken_slot(seed, [&](const Slot& slot) {
    if (!slot.for_good && slot.stands_at(seconds)) vehicles.push_back(slot.vehicle);
  });
  return vehicles;
}

}  // namespace voxatlas
