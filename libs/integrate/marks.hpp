#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "grid/grid.hpp"
#include "integrate/each_bit.hpp"

namespace voxatlas {

/// 8x8x8 bits of one brick: voxel (x, y, z) is bit 8 y + x of word z.
using BrickBits = std::array<std::uint64_t, 8>;

/// The same bits three times, each time with another axis as the word: a ray marks the plane of the
/// axis it mostly runs along, where each of its steps on that axis is a word of its own, so that no
/// mark waits for the one before. The bit is 8 v + u of the other two axes, u before v. Aligned, as
/// a plane then is one cache line.
struct alignas(64) BrickPlanes : std::array<BrickBits, 3> {};

/// ORs the planes of x and y into that of z, which is the brick's BrickBits, and clears them.
void merge_planes(BrickPlanes& planes);

/// A scan's cells at one depth as bits, over as many tiles as it touches. Setting a bit again
/// changes nothing: so every cell counts once in a scan, which is the paper's key buffering.
///
/// Layout:  a tile has 4096 bits, `top`, in Morton order. At depth 0..4 they are the cells
///          themselves, 8^depth of them. At depth 5..7 they say which bricks there are; a cell then
///          is the bit of its lowest voxel in that brick's planes. A tile is found by its place in
///          a window that wraps around and is wider than a scan reaches, a brick by its tile's
///          page: no key is hashed or compared.
/// Units:   a "cell" below is a voxel index >> (7 - depth), over the whole grid.
/// Threads: one at a time.
/// Cost:    a tile 0.5 kB (16.5 kB at depth 5..7), a brick 192 bytes; kept for the next scan. The
///          window is 4 bytes a tile of it, of which only pages that were used are real.
class Marks {
 public:
  static constexpr std::uint32_t kNone = ~0u;

  struct Tile {
    Index3 index{};
    TopBits top{};

    bool has(std::uint32_t bit) const { return top[bit >> 6] >> (bit & 63) & 1; }
    void set(std::uint32_t bit) { top[bit >> 6] |= std::uint64_t{1} << (bit & 63); }
  };

  Marks() { reset(kDepth, 1); }
  /// Forgets every mark; cells have `depth` from now on, and no two of them may lie in tiles more
  /// than `reach` apart on any axis.
  void reset(int depth, std::uint32_t reach);

  int depth() const { return depth_; }
  bool has_bricks() const { return depth_ > kBrickDepth; }

  /// The slot of a tile, found or added. `cell` is any cell in it.
  std::uint32_t tile_slot(const VoxelIndex& cell) {
    const Index3 tile{static_cast<std::uint32_t>(cell.x() >> depth_),
                      static_cast<std::uint32_t>(cell.y() >> depth_),
                      static_cast<std::uint32_t>(cell.z() >> depth_)};
    const auto slot = window_[window_place(tile)];
    return slot != 0 ? slot - 1 : add_tile(tile);
  }
  /// The slot of a brick of a tile, found or added.
  std::uint32_t brick_slot(std::uint32_t tile, std::uint32_t brick) {
    const auto slot = page(tile)[brick];
    return slot != 0 ? slot : add_brick(tile, brick);
  }
  /// The slot of a brick known to be there.
  std::uint32_t brick_slot_of(std::uint32_t tile, std::uint32_t brick) const {
    return pages_[(std::size_t{tile} + 1) * kBricks + brick];
  }

  /// Depth 7 only, coordinates in bricks over the whole grid. A brick's place is the sum of what
  /// its coordinates say on each axis; slot_at() is 0 where no brick is, which add_brick() adds.
  std::uint64_t place_on_axis(std::size_t axis, std::int32_t brick) const {
    return axis_places_[axis][static_cast<std::uint32_t>(brick) & axis_wrap_];
  }
  std::uint32_t slot_at(std::uint64_t place) const {
    return pages_[std::size_t{window_[place / kBricks]} * kBricks + place % kBricks];
  }
  std::uint32_t add_brick(const VoxelIndex& brick);

  /// Every reference is good until a tile or a brick is added.
  Tile& tile(std::uint32_t slot) { return tiles_[slot]; }
  const Tile& tile(std::uint32_t slot) const { return tiles_[slot]; }
  BrickPlanes& planes(std::uint32_t brick_slot) { return bricks_[brick_slot]; }
  /// A brick's marks, where none was set in another plane than z's since merge().
  BrickBits& bits(std::uint32_t brick_slot) { return bricks_[brick_slot][2]; }
  const BrickBits& bits(std::uint32_t brick_slot) const { return bricks_[brick_slot][2]; }
  void merge();

  std::uint32_t tile_count() const { return static_cast<std::uint32_t>(tiles_.size()); }
  /// Slots of bricks are below this one; slot 0 is nobody's and empty.
  std::uint32_t brick_slots() const { return static_cast<std::uint32_t>(bricks_.size()); }
  std::size_t memory_bytes() const;

 private:
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  std::size_t window_place(const Index3& tile) const {
    const std::size_t wrap = (std::size_t{1} << window_bits_) - 1;
    return (tile[0] & wrap) | (tile[1] & wrap) << window_bits_ |
           (tile[2] & wrap) << 2 * window_bits_;
  }
  std::uint32_t* page(std::uint32_t tile) {
    return pages_.data() + (std::size_t{tile} + 1) * kBricks;
  }
  std::uint32_t add_tile(const Index3& tile);
  std::uint32_t add_brick(std::uint32_t tile, std::uint32_t brick);
  void open_window(std::uint32_t reach);

  int depth_ = kDepth;
  unsigned window_bits_ = 0;  ///< The window is 2^window_bits_ tiles wide; 0: there is none yet.
  std::unique_ptr<std::uint32_t[], Free> window_;  ///< A tile's slot + 1, 0: none.
  std::uint32_t axis_wrap_ = 0;
  std::array<std::vector<std::uint64_t>, 3> axis_places_;
  std::vector<Tile> tiles_;
  std::vector<std::uint32_t> pages_;  ///< Brick slots, 0: none; the first page is nobody's, empty.
  std::vector<BrickPlanes> bricks_;
};

/// Where a cell's mark is: block = brick slot (depth 5..7) or tile slot (depth 0..4), and the bit
/// in it. Adds what is not there.
struct MarkPlace {
  std::uint32_t block;
  std::uint32_t bit;
};
MarkPlace set_mark(Marks& marks, const VoxelIndex& cell);

/// The same at depth 7, where nearly every endpoint goes: its brick is found without its tile, and
/// the call does not stand between two endpoints.
inline MarkPlace set_voxel_mark(Marks& marks, std::int32_t x, std::int32_t y, std::int32_t z) {
  const auto place = marks.place_on_axis(0, x >> 3) + marks.place_on_axis(1, y >> 3) +
                     marks.place_on_axis(2, z >> 3);
  auto slot = marks.slot_at(place);
  if (slot == 0) slot = marks.add_brick(VoxelIndex(x >> 3, y >> 3, z >> 3));
  const auto low = [](std::int32_t at) { return static_cast<std::uint32_t>(at) & 7; };
  const auto in_plane = low(y) << 3 | low(x);
  marks.bits(slot)[low(z)] |= std::uint64_t{1} << in_plane;
  return {slot, low(z) << 6 | in_plane};
}

/// Adds to `coarse` every cell of `cells`, merged, whose voxels are cells of `coarse`'s depth.
void add_cells(const Marks& cells, Marks& coarse);

/// Morton code of the low `kBrickDepth` (or fewer) bits of a brick's or coarse cell's coordinates.
inline std::uint32_t top_bit(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  constexpr std::array<std::uint16_t, 16> spread = {0,   1,   8,   9,   64,  65,  72,  73,
                                                    512, 513, 520, 521, 576, 577, 584, 585};
  return spread[x] | std::uint32_t{spread[y]} << 1 | std::uint32_t{spread[z]} << 2;
}

}  // namespace voxatlas
