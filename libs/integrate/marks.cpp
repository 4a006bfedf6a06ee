#include "integrate/marks.hpp"

#include <algorithm>

#include "grid/region_key.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kFirstTable = 1024;
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

void Marks::reset(int depth) {
  if (memory_bytes() > kKeptBytes) {
    tiles_ = std::vector<Tile>();
    pages_ = std::vector<std::unique_ptr<Page>>();
    bricks_ = std::vector<BrickPlanes>();
    table_ = std::vector<std::uint32_t>();
  }
  depth_ = depth;
  last_id_ = ~std::uint64_t{0};
  last_slot_ = kNone;
  tiles_.clear();
  bricks_.clear();
  if (table_.empty()) table_.resize(kFirstTable);
  std::fill(table_.begin(), table_.end(), kNone);
}

std::uint32_t Marks::find_or_add(std::uint64_t id) {
  const std::size_t wrap = table_.size() - 1;
  std::size_t at = splitmix64(id) & wrap;
  while (table_[at] != kNone && tiles_[table_[at]].id != id) at = (at + 1) & wrap;
  last_id_ = id;
  last_slot_ = table_[at] != kNone ? table_[at] : table_[at] = add_tile(id);
  if (2 * tiles_.size() > table_.size()) grow_table();
  return last_slot_;
}

std::uint32_t Marks::add_tile(std::uint64_t id) {
  const auto slot = tile_count();
  tiles_.push_back({id, {}});
  if (has_bricks() && pages_.size() <= slot) pages_.resize(slot + 1);
  // A page is not cleared: `top` says which entries are meant.
  if (has_bricks() && !pages_[slot]) pages_[slot].reset(new Page);
  return slot;
}

std::uint32_t Marks::add_brick(std::uint32_t tile, std::uint32_t brick) {
  const auto slot = brick_count();
  bricks_.emplace_back();
  tiles_[tile].set(brick);
  (*pages_[tile])[brick] = slot;
  return slot;
}

void Marks::grow_table() {
  table_.assign(table_.size() * 2, kNone);
  const std::size_t wrap = table_.size() - 1;
  for (std::uint32_t slot = 0; slot < tile_count(); ++slot) {
    std::size_t at = splitmix64(tiles_[slot].id) & wrap;
    while (table_[at] != kNone) at = (at + 1) & wrap;
    table_[at] = slot;
  }
}

std::size_t Marks::memory_bytes() const {
  return tiles_.capacity() * sizeof(Tile) + pages_.size() * sizeof(Page) +
         bricks_.capacity() * sizeof(BrickPlanes) + table_.capacity() * sizeof(std::uint32_t);
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

}  // namespace voxatlas
