#include "octree/cell_set.hpp"

#include <algorithm>
#include <bit>

#include "base/check.hpp"
#include "octree/brick_mask.hpp"

namespace voxatlas {
namespace {

bool is_coarse(int depth) { return depth <= kBrickDepth; }

std::size_t coarse_words(int depth) { return depth <= 2 ? 1 : std::size_t{1} << 3 * (depth - 2); }

/// A cell of depth 5 or 6 has all its voxels or none.
bool holds_whole_cells(const VoxelMask& mask, int depth) {
  VoxelMask whole{};
  for_each_bit(both(mask, lowest_voxels(depth)), [&](unsigned voxel) {
    const VoxelMask cell = cell_voxels(voxel, depth);
    for (std::size_t z = 0; z < 8; ++z) whole[z] |= cell[z];
  });
  return whole == mask;
}

bool valid_coarse(const CellSet& set) {
  if (!set.bricks.empty()) return false;
  if (set.coarse.empty()) return true;
  if (set.coarse.size() != coarse_words(set.depth)) return false;
  if (set.depth < 2 && set.coarse[0] >> (1 << 3 * set.depth) != 0) return false;
  return std::any_of(set.coarse.begin(), set.coarse.end(), [](auto word) { return word != 0; });
}

bool valid_bricks(const CellSet& set) {
  if (!set.coarse.empty()) return false;
  int last = -1;
  for (const auto& brick : set.bricks) {
    if (brick.brick <= last || brick.brick >= kBricks || !any_of(brick.bits)) return false;
    if (set.depth < kDepth && !holds_whole_cells(brick.bits, set.depth)) return false;
    last = brick.brick;
  }
  return true;
}

bool fits(const CellSet& set, CellKey cell) {
  return cell.depth == set.depth && cell.code >> 3 * cell.depth == 0;
}

auto lower_brick(auto& bricks, unsigned brick) {
  return std::lower_bound(bricks.begin(), bricks.end(), brick,
                          [](const BrickMask& mask, unsigned b) { return mask.brick < b; });
}

}  // namespace

std::uint64_t CellSet::size() const {
  std::uint64_t cells = 0;
  for (const auto word : coarse) cells += static_cast<std::uint64_t>(std::popcount(word));
  for (const auto& brick : bricks) {
    cells += count_of(depth == kDepth ? brick.bits : both(brick.bits, lowest_voxels(depth)));
  }
  return cells;
}

bool CellSet::valid() const {
  if (depth < 0 || depth > kDepth) return false;
  return is_coarse(depth) ? valid_coarse(*this) : valid_bricks(*this);
}

void CellSet::for_each(const std::function<void(CellKey)>& visit) const {
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    for (std::uint64_t word = coarse[i]; word != 0; word &= word - 1) {
      const auto code = 64 * i + static_cast<std::size_t>(std::countr_zero(word));
      visit({static_cast<std::uint8_t>(depth), static_cast<std::uint32_t>(code)});
    }
  }
  for (const auto& brick : bricks) {
    for_each_bit(both(brick.bits, lowest_voxels(depth)),
                 [&](unsigned voxel) { visit(cell_at(brick.brick, voxel, depth)); });
  }
}

bool CellSet::contains(CellKey cell) const {
  VOX_CHECK(fits(*this, cell));
  if (is_coarse(depth)) return !coarse.empty() && (coarse[cell.code / 64] >> cell.code % 64 & 1);
  const auto at = lower_brick(bricks, brick_of(cell));
  return at != bricks.end() && at->brick == brick_of(cell) &&
         has_voxel(at->bits, lowest_voxel_of(cell));
}

void CellSet::insert(CellKey cell) {
  VOX_CHECK(fits(*this, cell));
  if (is_coarse(depth)) {
    coarse.resize(coarse_words(depth));
    coarse[cell.code / 64] |= std::uint64_t{1} << cell.code % 64;
    return;
  }
  auto at = lower_brick(bricks, brick_of(cell));
  if (at == bricks.end() || at->brick != brick_of(cell)) {
    at = bricks.insert(at, {static_cast<std::uint16_t>(brick_of(cell)), {}});
  }
  const VoxelMask voxels = cell_voxels(lowest_voxel_of(cell), depth);
  for (std::size_t z = 0; z < 8; ++z) at->bits[z] |= voxels[z];
}

}  // namespace voxatlas
