#include "codec/pyramid.hpp"

#include <algorithm>
#include <cstring>

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

  void mark(const Brick& brick) {
    const bool all = brick.known == kAllVoxels;
    LogOdds before = 0;  // Runs are long.
    bool begun = false;
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      const LogOdds value = brick.log_odds[voxel];
      if (begun && value == before) continue;
      if (!all && !has_voxel(brick.known, voxel)) continue;
      mark(value);
      before = value;
      begun = true;
    }
  }

  std::vector<Place> places_ = std::vector<Place>(kValues);
};

/// Exceptions and highest places of depths 6, 5 and 4 from the voxels and the ground.
void sum_up(PyramidBrick& brick) {
  for (int depth = kDepth; depth > kBrickDepth; --depth) {
    const unsigned below = PyramidBrick::first(depth);
    const unsigned here = PyramidBrick::first(depth - 1);
    for (unsigned cell = 0; cell < below - here; ++cell) {
      const Place* children = brick.highest.data() + below + std::size_t{8} * cell;
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

  Place of(const Place* voxels) {
    Place best = voxels[0];
    unsigned most = 0;
    for (unsigned i = 0; i < kBrickVoxels;) {
      unsigned end = i + 1;
      while (end < kBrickVoxels && voxels[end] == voxels[i]) ++end;
      const unsigned count = counts_[voxels[i]] += end - i;
      if (count > most) {
        most = count;
        best = voxels[i];
      }
      i = end;
    }
    for (unsigned i = 0; i < kBrickVoxels; ++i) counts_[voxels[i]] = 0;
    return best;
  }

 private:
  std::vector<unsigned> counts_;
};

/// The voxels' places, in Morton order. False where all are the same.
bool read_places(const Brick& brick, const Places& places, Place* voxels) {
  LogOdds before = brick.log_odds[0];
  Place place = places.of(before);
  for (unsigned code = 0; code < kBrickVoxels; ++code) {
    const LogOdds value = brick.log_odds[kVoxelOfMorton[code]];
    if (value != before) {
      before = value;
      place = places.of(value);
    }
    voxels[code] = place;
  }
  if (brick.known != kAllVoxels) {
    for (unsigned code = 0; code < kBrickVoxels; ++code) {
      if (!has_voxel(brick.known, kVoxelOfMorton[code])) voxels[code] = kUnknown;
    }
  }
  return std::memcmp(voxels, voxels + 1, sizeof *voxels * (kBrickVoxels - 1)) != 0;
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
    for (unsigned i = first; i < first + count; ++i) {
      table.make_uniform(i, {pyramid.palette[highest - 1u], {}});
    }
  }
}

}  // namespace

std::vector<LogOdds> Pyramid::values() const {
  std::vector<LogOdds> values{0};
  values.insert(values.end(), palette.begin(), palette.end());
  return values;
}

bool places_fit(const BrickTable& table) { return Places(table).palette.size() < kValues; }

Pyramid pyramid_of(const BrickTable& table) {
  Pyramid pyramid;
  Places places(table);
  VOX_CHECK(places.palette.size() < kValues);
  Majority majority(places.palette.size() + 1);
  for (unsigned i = 0; i < kBricks; ++i) {
    auto& slot = pyramid.slots[i];
    if (table.is_empty(i)) continue;
    slot.kind = Pyramid::Kind::kUniform;
    if (table.is_mixed(i)) {
      auto& brick = pyramid.bricks.emplace_back();
      if (read_places(table.mixed(i), places, brick.voxels())) {
        slot.kind = Pyramid::Kind::kMixed;
        slot.mixed = static_cast<std::uint16_t>(pyramid.bricks.size() - 1);
        slot.ground = brick.ground = majority.of(brick.voxels());
        sum_up(brick);
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
