#include "integrate/marks.hpp"

#include <algorithm>
#include <new>

#include "grid/morton.hpp"
#include "integrate/each_bit.hpp"

namespace voxatlas {
namespace {

constexpr unsigned kFewestBits = 5;  ///< A window of 32 tiles is 128 kB.
/// A scan that needed more than this is rare: its buffers are given back, not kept.
constexpr std::size_t kKeptBytes = std::size_t{256} << 20;

/// Exchanges, in each pair of words, the bits under `mask << shift` of the first with those under
/// `mask` of the second.
void exchange(std::uint64_t& a, std::uint64_t& b, int shift, std::uint64_t mask) {
  const std::uint64_t swapped = (a >> shift ^ b) & mask;
  a ^= swapped << shift;
  b ^= swapped;
}

/// Byte i of word j becomes byte j of word i.
void transpose_bytes(BrickBits& w) {
  for (std::size_t i = 0; i < 4; ++i) exchange(w[i], w[i + 4], 32, 0x00000000ffffffffu);
  for (const std::size_t i : {0, 1, 4, 5}) exchange(w[i], w[i + 2], 16, 0x0000ffff0000ffffu);
  for (const std::size_t i : {0, 2, 4, 6}) exchange(w[i], w[i + 1], 8, 0x00ff00ff00ff00ffu);
}

/// Bit i of byte j becomes bit j of byte i.
std::uint64_t transpose_bits(std::uint64_t w) {
  const auto swap = [&](int shift, std::uint64_t mask) {
    const std::uint64_t swapped = (w ^ w >> shift) & mask;
    w ^= swapped ^ swapped << shift;
  };
  swap(7, 0x00aa00aa00aa00aau);
  swap(14, 0x0000cccc0000ccccu);
  swap(28, 0x00000000f0f0f0f0u);
  return w;
}

bool any(const BrickBits& bits) {
  std::uint64_t all = 0;
  for (const auto word : bits) all |= word;
  return all != 0;
}

}  // namespace

void merge_planes(BrickPlanes& planes) {
  for (const std::size_t axis : {0, 1}) {
    auto& plane = planes[axis];
    if (!any(plane)) continue;
    transpose_bytes(plane);  // Words of x or y with bytes of z: now the other way round.
    for (std::size_t z = 0; z < plane.size(); ++z) {
      planes[2][z] |= axis == 0 ? transpose_bits(plane[z]) : plane[z];
    }
    plane.fill(0);
  }
}

void Marks::merge() {
  for (auto& planes : bricks_) merge_planes(planes);
}

void Marks::reset(int depth, std::uint32_t reach) {
  if (memory_bytes() > kKeptBytes) {
    tiles_ = std::vector<Tile>();
    pages_ = std::vector<std::uint32_t>();
    bricks_ = std::vector<BrickPlanes>();
    window_bits_ = 0;
  }
  if (window_bits_ == 0 || reach >> window_bits_ != 0) {
    open_window(reach);
  } else {
    for (const auto& tile : tiles_) window_[window_place(tile.index)] = 0;
  }
  depth_ = depth;
  tiles_.clear();
  bricks_.resize(1);
  if (pages_.empty()) pages_.resize(kBricks);
}

void Marks::open_window(std::uint32_t reach) {
  window_bits_ = std::max(kFewestBits, static_cast<unsigned>(std::bit_width(reach)));
  // Zeros that cost nothing until they are used: a scan's tiles are a small part of its window.
  window_.reset(static_cast<std::uint32_t*>(
      std::calloc(std::size_t{1} << 3 * window_bits_, sizeof(std::uint32_t))));
  if (window_ == nullptr) throw std::bad_alloc();
  const std::size_t bricks = std::size_t{16} << window_bits_;
  axis_wrap_ = static_cast<std::uint32_t>(bricks - 1);
  for (unsigned axis = 0; axis < 3; ++axis) {
    axis_places_[axis].resize(bricks);
    for (std::size_t i = 0; i < bricks; ++i) {
      const std::uint64_t in_tile = top_bit(static_cast<std::uint32_t>(i % 16), 0, 0);
      axis_places_[axis][i] = (i / 16 << axis * window_bits_) * kBricks + (in_tile << axis);
    }
  }
}

std::uint32_t Marks::add_tile(const Index3& tile) {
  const auto slot = tile_count();
  tiles_.push_back({tile, {}});
  window_[window_place(tile)] = slot + 1;
  if (has_bricks()) {
    pages_.resize(std::max(pages_.size(), (std::size_t{slot} + 2) * kBricks));
    std::fill_n(page(slot), kBricks, 0);
  }
  return slot;
}

std::uint32_t Marks::add_brick(std::uint32_t tile, std::uint32_t brick) {
  const auto slot = brick_slots();
  bricks_.emplace_back();
  tiles_[tile].set(brick);
  return page(tile)[brick] = slot;
}

std::uint32_t Marks::add_brick(const VoxelIndex& brick) {
  const auto tile = tile_slot(brick * 8);
  const auto low = [&](int axis) { return static_cast<std::uint32_t>(brick[axis]) & 15; };
  return brick_slot(tile, top_bit(low(0), low(1), low(2)));
}

std::size_t Marks::memory_bytes() const {
  return tiles_.capacity() * sizeof(Tile) + pages_.capacity() * sizeof(std::uint32_t) +
         bricks_.capacity() * sizeof(BrickPlanes);
}

MarkPlace set_mark(Marks& marks, const VoxelIndex& cell) {
  const auto tile = marks.tile_slot(cell);
  const int shift = marks.has_bricks() ? marks.depth() - kBrickDepth : 0;
  const std::uint32_t wrap = (1u << (marks.depth() - shift)) - 1;
  const auto top = [&](int axis) { return static_cast<std::uint32_t>(cell[axis] >> shift) & wrap; };
  const auto bit = top_bit(top(0), top(1), top(2));
  if (!marks.has_bricks()) {
    marks.tile(tile).set(bit);
    return {tile, bit};
  }
  const auto slot = marks.brick_slot(tile, bit);
  const int up = kDepth - marks.depth();
  const auto low = [&](int axis) { return static_cast<std::uint32_t>(cell[axis] << up) & 7; };
  const auto voxel = low(2) << 6 | low(1) << 3 | low(0);
  marks.bits(slot)[voxel >> 6] |= std::uint64_t{1} << (voxel & 63);
  return {slot, voxel};
}

void add_cells(const Marks& cells, Marks& coarse) {
  for (std::uint32_t slot = 0; slot < cells.tile_count(); ++slot) {
    const auto& tile = cells.tile(slot);
    const VoxelIndex low(static_cast<int>(tile.index[0]), static_cast<int>(tile.index[1]),
                         static_cast<int>(tile.index[2]));
    for_each_top(tile.top, [&](std::uint32_t brick) {
      const auto at = morton_decode(brick);
      const VoxelIndex corner =
          low * kTileVoxels +
          8 * VoxelIndex(static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2]));
      const auto& bits = cells.bits(cells.brick_slot_of(slot, brick));
      for (int z = 0; z < 8; ++z) {
        for_each_bit_of(bits[static_cast<std::size_t>(z)], [&](std::uint32_t bit) {
          set_mark(coarse, corner + VoxelIndex(bit & 7, bit >> 3, z));
        });
      }
    });
  }
}

}  // namespace voxatlas
