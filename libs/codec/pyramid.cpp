#include "codec/pyramid.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/check.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kValues = std::size_t{1} << 16;

std::size_t slot_of(LogOdds value) { return static_cast<std::uint16_t>(value); }

/// A tile's palette, and the place of each value in it.
class Places {
 public:
  explicit Places(const BrickTable& table) {
    for (unsigned i = 0; i < kBricks; ++i) {
      if (table.is_mixed(i)) {
        mark(table.mixed(i));
      } else if (!table.is_empty(i)) {
        mark(table.uniform_log_odds(i));
      }
    }
    std::sort(palette.begin(), palette.end());
    for (std::size_t i = 0; i < palette.size(); ++i) {
      places_[slot_of(palette[i])] = static_cast<Place>(i + 1);
    }
  }

  Place of(LogOdds value) const { return places_[slot_of(value)]; }

  std::vector<LogOdds> palette;

 private:
  void mark(LogOdds value) {
    if (places_[slot_of(value)] != 0) return;
    places_[slot_of(value)] = 1;
    palette.push_back(value);
  }

  /// By rows of eight: most are all of one value, or unknown.
  void mark(const Brick& brick) {
    for (unsigned row = 0; row < kBrickVoxels / 8; ++row) {
      const unsigned known = brick.known[row / 8] >> 8 * (row % 8) & 0xff;
      std::array<LogOdds, 8> values, same;
      std::memcpy(values.data(), &brick.log_odds[std::size_t{8} * row], sizeof values);
      same.fill(values[0]);
      if (known == 0xff && values == same) {
        mark(values[0]);
        continue;
      }
      for (unsigned x = 0; x < 8; ++x) {
        if ((known >> x & 1) != 0) mark(values[x]);
      }
    }
  }

  std::vector<Place> places_ = std::vector<Place>(kValues);
};

/// Which cells of depth 6, a bit each, have eight voxels of one place.
using Alike = std::uint64_t;

/// Exceptions and highest places of depths 6, 5 and 4 from the voxels and the ground.
void sum_up(PyramidBrick& brick, Alike alike) {
  for (int depth = kDepth; depth > kBrickDepth; --depth) {
    const unsigned below = PyramidBrick::first(depth);
    const unsigned here = PyramidBrick::first(depth - 1);
    for (unsigned cell = 0; cell < below - here; ++cell) {
      const Place* children = brick.highest.data() + below + std::size_t{8} * cell;
      if (depth == kDepth && (alike >> cell & 1) != 0) {
        brick.exceptions[here + cell] = children[0] != brick.ground ? 0xff : 0;
        brick.highest[here + cell] = children[0];
        continue;
      }
      unsigned mask = 0;
      Place highest = kUnknown;
      for (unsigned octant = 0; octant < 8; ++octant) {
        const bool differs = depth == kDepth ? children[octant] != brick.ground
                                             : brick.exceptions[below + 8 * cell + octant] != 0;
        mask |= (differs ? 1u : 0u) << octant;
        highest = std::max(highest, children[octant]);
      }
      brick.exceptions[here + cell] = static_cast<std::uint8_t>(mask);
      brick.highest[here + cell] = highest;
    }
  }
}

/// The place that most voxels have; of several the one that was first so often.
class Majority {
 public:
  explicit Majority(std::size_t places) : counts_(places) {}

  Place of(const Place* voxels, Alike alike) {
    for (unsigned cell = 0; cell < kBrickVoxels / 8; ++cell) {
      const Place* own = voxels + std::size_t{8} * cell;
      if ((alike >> cell & 1) != 0) {
        add(own[0], 8);
      } else {
        for (unsigned i = 0; i < 8; ++i) add(own[i], 1);
      }
    }
    unsigned most = 0, so_often = 0;
    Place best = kUnknown;
    for (const Place place : seen_) {
      const unsigned count = std::exchange(counts_[place], 0);
      so_often = count > most ? 1 : so_often + (count == most ? 1 : 0);
      best = count > most ? place : best;
      most = std::max(most, count);
    }
    seen_.clear();
    return so_often == 1 ? best : first_to_be(most, voxels);
  }

 private:
  void add(Place place, unsigned count) {
    if (counts_[place] == 0) seen_.push_back(place);
    counts_[place] += count;
  }

  Place first_to_be(unsigned most, const Place* voxels) {
    unsigned at = 0;
    while (++counts_[voxels[at]] < most) ++at;
    for (unsigned i = 0; i <= at; ++i) counts_[voxels[i]] = 0;
    return voxels[at];
  }

  std::vector<unsigned> counts_;
  std::vector<Place> seen_;
};

/// The voxels of a cell of depth 6 in Morton order are four pairs along x.
constexpr std::array<unsigned, 4> kPairs{0, 8, 64, 72};

/// Those that are known, a bit each in Morton order.
unsigned known_of_cell(const Brick& brick, unsigned first_voxel) {
  unsigned known = 0;
  for (unsigned i = 0; i < 4; ++i) {
    const unsigned voxel = first_voxel + kPairs[i];
    known |= static_cast<unsigned>(brick.known[voxel >> 6] >> (voxel & 63) & 3) << 2 * i;
  }
  return known;
}

/// The places of a brick, in Morton order, a cell of depth 6 at a time: most are all of one.
Alike read_places(const Brick& brick, const Places& places, Place* voxels) {
  const bool all = brick.known == kAllVoxels;
  Alike alike = 0;
  for (unsigned cell = 0; cell < kBrickVoxels / 8; ++cell) {
    const unsigned first = kVoxelOfMorton[std::size_t{8} * cell];
    std::array<LogOdds, 8> values;
    for (std::size_t i = 0; i < 4; ++i) {
      std::memcpy(&values[2 * i], &brick.log_odds[first + kPairs[i]], 2 * sizeof(LogOdds));
    }
    const unsigned known = all ? 0xff : known_of_cell(brick, first);
    Place* own = voxels + std::size_t{8} * cell;
    std::array<LogOdds, 8> same;
    same.fill(values[0]);
    const bool one = known == 0 || (known == 0xff && values == same);
    if (one) {
      std::fill_n(own, 8, known == 0 ? kUnknown : places.of(values[0]));
      alike |= Alike{1} << cell;
      continue;
    }
    for (unsigned i = 0; i < 8; ++i) {
      own[i] = (known >> i & 1) != 0 ? places.of(values[i]) : kUnknown;
    }
  }
  return alike;
}

bool is_one_place(const Place* voxels, Alike alike) {
  return alike == ~Alike{0} &&
         std::memcmp(voxels, voxels + 1, sizeof *voxels * (kBrickVoxels - 1)) == 0;
}

/// Fills a cut brick: `count` voxels in Morton order from `first` on.
void fill(Brick& brick, unsigned first, unsigned count, LogOdds log_odds) {
  for (unsigned code = first; code < first + count; ++code) {
    const unsigned voxel = kVoxelOfMorton[code];
    brick.log_odds[voxel] = log_odds;
    brick.known[voxel >> 6] |= std::uint64_t{1} << (voxel & 63);
  }
}

void write_brick(const PyramidBrick& from, std::span<const LogOdds> palette, int depth, Brick& to) {
  const unsigned cells = 1u << 3 * (depth - kBrickDepth);
  const unsigned voxels = kBrickVoxels / cells;
  const Place* highest = from.highest.data() + PyramidBrick::first(depth);
  for (unsigned cell = 0; cell < cells; ++cell) {
    if (highest[cell] == kUnknown) continue;
    fill(to, cell * voxels, voxels, palette[highest[cell] - 1u]);
  }
}

/// The highest place of each cell of a depth above the bricks', for all its bricks.
void cut_above_bricks(const Pyramid& pyramid, int depth, BrickTable& table) {
  const unsigned count = 1u << 3 * (kBrickDepth - depth);
  for (unsigned first = 0; first < kBricks; first += count) {
    Place highest = kUnknown;
    for (unsigned i = first; i < first + count; ++i) {
      highest = std::max(highest, pyramid.slots[i].highest);
    }
    if (highest == kUnknown) continue;
    table.make_uniform(BrickRange{first, count}, {pyramid.palette[highest - 1u], {}});
  }
}

/// Whether any voxel has it; unknown ones have 0.
bool holds(const BrickTable& table, LogOdds value) {
  bool found = false;
  for (unsigned i = 0; i < kBricks && !found; ++i) {
    found = table.is_uniform(i) && table.uniform_log_odds(i) == value;
    if (table.is_mixed(i)) found = any_of(equal_to(table.mixed(i), value));
  }
  return found;
}

}  // namespace

std::vector<LogOdds> Pyramid::values() const {
  std::vector<LogOdds> values{0};
  values.insert(values.end(), palette.begin(), palette.end());
  return values;
}

bool places_fit(const BrickTable& table) {
  constexpr LogOdds kLowest = INT16_MIN;  // Outside |L| < 8, so rare.
  return !holds(table, kLowest) || Places(table).palette.size() < kValues;
}

Pyramid pyramid_of(const BrickTable& table) {
  Pyramid pyramid;
  Places places(table);
  VOX_CHECK(places.palette.size() < kValues);
  Majority majority(places.palette.size() + 1);
  unsigned mixed = 0;
  for (unsigned i = 0; i < kBricks; ++i) mixed += table.is_mixed(i) ? 1 : 0;
  pyramid.bricks.reserve(mixed);
  for (unsigned i = 0; i < kBricks; ++i) {
    auto& slot = pyramid.slots[i];
    if (table.is_empty(i)) continue;
    slot.kind = Pyramid::Kind::kUniform;
    if (table.is_mixed(i)) {
      auto& brick = pyramid.bricks.emplace_back();
      const Alike alike = read_places(table.mixed(i), places, brick.voxels());
      if (!is_one_place(brick.voxels(), alike)) {
        slot.kind = Pyramid::Kind::kMixed;
        slot.mixed = static_cast<std::uint16_t>(pyramid.bricks.size() - 1);
        slot.ground = brick.ground = majority.of(brick.voxels(), alike);
        sum_up(brick, alike);
        slot.highest = brick.highest[0];
        continue;
      }
      slot.ground = brick.voxels()[0];  // Mixed by its colours alone.
      pyramid.bricks.pop_back();
    } else {
      slot.ground = places.of(table.uniform_log_odds(i));
    }
    slot.highest = slot.ground;
  }
  pyramid.palette = std::move(places.palette);
  return pyramid;
}

BrickTable bricks_of(const Pyramid& pyramid, int depth) {
  BrickTable table;
  if (depth < kBrickDepth) {
    cut_above_bricks(pyramid, depth, table);
    return table;
  }
  const auto values = pyramid.values();
  for (unsigned i = 0; i < kBricks; ++i) {
    const auto& slot = pyramid.slots[i];
    if (slot.kind == Pyramid::Kind::kEmpty) continue;
    if (slot.kind == Pyramid::Kind::kUniform || depth == kBrickDepth) {
      table.make_uniform(i, {values[slot.highest], {}});
    } else if (depth == kDepth) {
      const auto& brick = pyramid.bricks[slot.mixed];
      fill_brick(table.expand(i), brick.ground, brick.voxel_mask(), values,
                 [&](unsigned code) { return brick.voxels()[code]; });
      table.settle(i);
    } else {
      write_brick(pyramid.bricks[slot.mixed], pyramid.palette, depth, table.expand(i));
      table.settle(i);
    }
  }
  return table;
}

}  // namespace voxatlas
