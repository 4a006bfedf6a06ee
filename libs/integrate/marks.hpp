#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "grid/grid.hpp"

namespace voxatlas {

/// 8x8x8 bits of one brick: voxel (x, y, z) is bit 8 y + x of word z.
using BrickBits = std::array<std::uint64_t, 8>;

/// The same bits three times, each time with another axis as the word: a ray marks the plane of the
/// axis it mostly runs along, where each of its steps on that axis is a word of its own, so that no
/// mark waits for the one before. The bit is 8 v + u of the other two axes, u before v.
using BrickPlanes = std::array<BrickBits, 3>;

/// ORs the planes of x and y into that of z, which is the brick's BrickBits, and clears them.
void merge_planes(BrickPlanes& planes);

/// A scan's cells at one depth as bits, over as many tiles as it touches. Setting a bit again
/// changes nothing: so every cell counts once in a scan, which is the paper's key buffering.
///
/// Layout:  a tile has 4096 bits, `top`, in Morton order. At depth 0..4 they are the cells
///          themselves, 8^depth of them. At depth 5..7 they say which bricks have a page entry; a
///          cell then is the bit of its lowest voxel in that brick's planes.
/// Units:   a "cell" below is a voxel index >> (7 - depth), over the whole grid.
/// Threads: one at a time.
/// Cost:    a tile 0.5 kB (16.5 kB at depth 5..7), a brick 192 bytes; kept for the next scan.
class Marks {
 public:
  static constexpr std::uint32_t kNone = ~0u;
  using Page = std::array<std::uint32_t, kBricks>;

  struct Tile {
    std::uint64_t id = 0;  ///< Its index, 21 bits an axis, x lowest.
    std::array<std::uint64_t, 64> top{};

    bool has(std::uint32_t bit) const { return top[bit >> 6] >> (bit & 63) & 1; }
    void set(std::uint32_t bit) { top[bit >> 6] |= std::uint64_t{1} << (bit & 63); }
    Index3 index() const {
      constexpr std::uint64_t axis = (1u << 21) - 1;
      return {static_cast<std::uint32_t>(id & axis), static_cast<std::uint32_t>(id >> 21 & axis),
              static_cast<std::uint32_t>(id >> 42)};
    }
  };

  Marks() { reset(kDepth); }
  /// Forgets every mark; cells have `depth` from now on.
  void reset(int depth);

  int depth() const { return depth_; }
  bool has_bricks() const { return depth_ > kBrickDepth; }

  /// The slot of a tile, found or added. `cell` is any cell in it.
  std::uint32_t tile_slot(const VoxelIndex& cell) {
    const auto id = id_of(cell.x() >> depth_, cell.y() >> depth_, cell.z() >> depth_);
    return id == last_id_ ? last_slot_ : find_or_add(id);
  }
  /// The slot of a brick of a tile, found or added.
  std::uint32_t brick_slot(std::uint32_t tile, std::uint32_t brick) {
    if (tiles_[tile].has(brick)) return (*pages_[tile])[brick];
    return add_brick(tile, brick);
  }
  /// The slot of a brick known to be there.
  std::uint32_t brick_slot_of(std::uint32_t tile, std::uint32_t brick) const {
    return (*pages_[tile])[brick];
  }

  /// Every reference is good until a tile or a brick is added.
  Tile& tile(std::uint32_t slot) { return tiles_[slot]; }
  const Tile& tile(std::uint32_t slot) const { return tiles_[slot]; }
  BrickPlanes& planes(std::uint32_t brick_slot) { return bricks_[brick_slot]; }
  /// A brick's marks, where none was set in another plane than z's since merge().
  BrickBits& bits(std::uint32_t brick_slot) { return bricks_[brick_slot][2]; }
  const BrickBits& bits(std::uint32_t brick_slot) const { return bricks_[brick_slot][2]; }
  void merge();

  std::uint32_t tile_count() const { return static_cast<std::uint32_t>(tiles_.size()); }
  std::uint32_t brick_count() const { return static_cast<std::uint32_t>(bricks_.size()); }
  std::size_t memory_bytes() const;

 private:
  static std::uint64_t id_of(std::int32_t x, std::int32_t y, std::int32_t z) {
    return static_cast<std::uint64_t>(x) | static_cast<std::uint64_t>(y) << 21 |
           static_cast<std::uint64_t>(z) << 42;
  }
  std::uint32_t find_or_add(std::uint64_t id);
  std::uint32_t add_tile(std::uint64_t id);
  std::uint32_t add_brick(std::uint32_t tile, std::uint32_t brick);
  void grow_table();

  int depth_ = kDepth;
  std::uint64_t last_id_ = ~std::uint64_t{0};
  std::uint32_t last_slot_ = kNone;
  std::vector<Tile> tiles_;
  std::vector<std::unique_ptr<Page>> pages_;  ///< By tile slot; more than tiles after a reset.
  std::vector<BrickPlanes> bricks_;
  std::vector<std::uint32_t> table_;  ///< Open addressing: tile slot, or kNone.
};

/// Where a cell's mark is: block = brick slot (depth 5..7) or tile slot (depth 0..4), and the bit
/// in it. Adds what is not there.
struct MarkPlace {
  std::uint32_t block;
  std::uint32_t bit;
};
MarkPlace set_mark(Marks& marks, const VoxelIndex& cell);

/// Morton code of the low `kBrickDepth` (or fewer) bits of a brick's or coarse cell's coordinates.
inline std::uint32_t top_bit(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  constexpr std::array<std::uint16_t, 16> spread = {0,   1,   8,   9,   64,  65,  72,  73,
                                                    512, 513, 520, 521, 576, 577, 584, 585};
  return spread[x] | std::uint32_t{spread[y]} << 1 | std::uint32_t{spread[z]} << 2;
}

}  // namespace voxatlas
