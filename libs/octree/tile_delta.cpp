#include "octree/tile_delta.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "octree/brick_mask.hpp"

namespace voxatlas {
namespace {

using BrickPlane = std::array<std::uint64_t, kBricks / 64>;

/// The bricks a coarse set covers.
BrickPlane covered_bricks(const CellSet& set) {
  BrickPlane plane{};
  const int shift = 3 * (kBrickDepth - set.depth);
  set.for_each([&](CellKey cell) {
    for (unsigned i = 0; i < 1u << shift; ++i) {
      const unsigned brick = (cell.code << shift) + i;
      plane[brick / 64] |= std::uint64_t{1} << brick % 64;
    }
  });
  return plane;
}

bool planes_meet(const BrickPlane& a, const BrickPlane& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if ((a[i] & b[i]) != 0) return true;
  }
  return false;
}

bool meets(const BrickPlane& plane, const std::vector<BrickMask>& bricks) {
  return std::any_of(bricks.begin(), bricks.end(), [&](const BrickMask& mask) {
    return (plane[mask.brick / 64] >> mask.brick % 64 & 1) != 0;
  });
}

bool bricks_meet(const std::vector<BrickMask>& a, const std::vector<BrickMask>& b) {
  auto other = b.begin();
  for (const auto& mask : a) {
    other = std::find_if(other, b.end(), [&](const auto& m) { return m.brick >= mask.brick; });
    if (other == b.end()) return false;
    if (other->brick == mask.brick && any_of(both(mask.bits, other->bits))) return true;
  }
  return false;
}

/// True when a voxel lies in both sets.
bool meet(const CellSet& a, const CellSet& b) {
  if (a.empty() || b.empty()) return false;
  if (a.depth > kBrickDepth && b.depth > kBrickDepth) return bricks_meet(a.bricks, b.bricks);
  if (a.depth > kBrickDepth) return meets(covered_bricks(b), a.bricks);
  if (b.depth > kBrickDepth) return meets(covered_bricks(a), b.bricks);
  return planes_meet(covered_bricks(a), covered_bricks(b));
}

bool coarse_within(const CellSet& part, const CellSet& whole) {
  if (part.coarse.empty()) return true;
  return std::equal(part.coarse.begin(), part.coarse.end(), whole.coarse.begin(),
                    whole.coarse.end(), [](auto p, auto w) { return (p & ~w) == 0; });
}

bool bricks_within(const CellSet& part, const CellSet& whole) {
  auto other = whole.bricks.begin();
  for (const auto& mask : part.bricks) {
    other = std::find_if(other, whole.bricks.end(),
                         [&](const auto& m) { return m.brick >= mask.brick; });
    if (other == whole.bricks.end() || other->brick != mask.brick) return false;
    if (both(mask.bits, other->bits) != mask.bits) return false;
  }
  return true;
}

}  // namespace

bool TileDelta::valid() const {
  if (!misses.valid() || !hits.valid() || !coloured.valid()) return false;
  if (coloured.depth != hits.depth || colours.size() != coloured.size()) return false;
  return coarse_within(coloured, hits) && bricks_within(coloured, hits) && !meet(misses, hits);
}

}  // namespace voxatlas
