#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "octree/brick.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// A log-odds' place in the tile's palette, counted from 1; 0 is unknown. As the palette is sorted,
/// places compare like the values, and unknown is below them all.
using Place = std::uint16_t;
inline constexpr Place kUnknown = 0;

/// A brick whose voxels do not all have the same log-odds: what most of them are (its *ground*) and
/// which cells hold anything else (*exceptions*), with the highest place in each cell.
///
/// Layout: children of cell c of one depth are cells 8c..8c+7 of the next, in Morton order.
struct PyramidBrick {
  /// For cells of depth 4..6 that are exceptions (depth 4: always): bit o: child o is one.
  std::array<std::uint8_t, 1 + 8 + 64> exceptions{};
  /// For cells of depth 4..7: the highest place among its voxels; at depth 7 the voxel's own.
  std::array<Place, 1 + 8 + 64 + 512> highest{};
  Place ground = kUnknown;

  /// Where the cells of a depth begin, in both arrays.
  static constexpr unsigned first(int depth) {
    return depth == 4 ? 0 : depth == 5 ? 1 : depth == 6 ? 9 : 73;
  }
  const Place* voxels() const { return highest.data() + first(kDepth); }
  Place* voxels() { return highest.data() + first(kDepth); }
  /// Which voxels are exceptions: 512 bits in Morton order.
  const std::uint8_t* voxel_mask() const { return exceptions.data() + first(kDepth - 1); }
};

/// Calls visit(Morton number) for every bit of a mask of a brick's voxels, as the exceptions of its
/// cells of depth 6 are one.
template <class Visit>
void for_each_exception(const std::uint8_t* mask, Visit visit) {
  for (unsigned first = 0; first < kBrickVoxels; first += 64) {
    std::uint64_t word;
    std::memcpy(&word, mask + first / 8, sizeof word);
    for (; word != 0; word &= word - 1) {
      visit(first + static_cast<unsigned>(std::countr_zero(word)));
    }
  }
}

/// Makes a brick, empty so far, of its ground and the places of its exceptions. `values` by place;
/// that of kUnknown is 0.
template <class PlaceOf>
void fill_brick(Brick& brick, Place ground, const std::uint8_t* mask,
                std::span<const LogOdds> values, PlaceOf place_of) {
  if (ground != kUnknown) {
    brick.log_odds.fill(values[ground]);
    brick.known = kAllVoxels;
  }
  for_each_exception(mask, [&](unsigned code) {
    const auto place = place_of(code);
    const unsigned voxel = kVoxelOfMorton[code];
    const std::uint64_t bit = std::uint64_t{1} << (voxel & 63);
    if (place == kUnknown) {
      brick.known[voxel >> 6] &= ~bit;
    } else if (ground == kUnknown) {
      brick.known[voxel >> 6] |= bit;
    }
    brick.log_odds[voxel] = values[place];
  });
}

/// The log-odds of a tile, made ready for coding from the top down. Colours are apart.
///
/// Memory: at most 4096 PyramidBricks, 5.2 MB, and a palette of 65 536.
struct Pyramid {
  enum class Kind : std::uint8_t { kEmpty = 0, kUniform = 1, kMixed = 2 };

  struct Slot {
    Kind kind = Kind::kEmpty;
    std::uint16_t mixed = 0;  ///< Its number among `bricks`.
    Place ground = kUnknown;  ///< Of a uniform brick its only place; of a mixed one as there.
    Place highest = kUnknown;
  };

  std::vector<LogOdds> palette;  ///< Rising; place p is palette[p - 1].
  std::vector<Slot> slots{kBricks};
  std::vector<PyramidBrick> bricks;  ///< The mixed ones, in the order of their slots.

  /// The palette by place, 0 first.
  std::vector<LogOdds> values() const;

  const PyramidBrick& mixed(unsigned slot) const { return bricks[slots[slot].mixed]; }
};

/// True but for a tile that holds each of the 65 536 log-odds.
bool places_fit(const BrickTable& table);

/// Of a tile whose places fit.
Pyramid pyramid_of(const BrickTable& table);

/// Log-odds of a tile cut at `depth`: every cell of that depth which knows anything is the highest
/// log-odds in it; 7 gives the tile itself. Only what lies above the cut need be there.
BrickTable bricks_of(const Pyramid& pyramid, int depth);

}  // namespace voxatlas
