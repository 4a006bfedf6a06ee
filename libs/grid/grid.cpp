#include "grid/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/check.hpp"

namespace voxatlas {
namespace {

constexpr int kMaxCellsPerMetre = 20;
constexpr std::uint32_t kTilesPerCellOfMetre =
    100'000;  // 12 800 km / 128, eq. (4) for r_max = 1/k.

}  // namespace

Grid::Grid(int cells_per_metre)
    : cells_per_metre_(cells_per_metre),
      tiles_per_axis_(kTilesPerCellOfMetre * static_cast<std::uint32_t>(cells_per_metre)),
      half_voxels_(static_cast<std::int32_t>(tiles_per_axis_ * (kTileVoxels / 2))),
      product_exact_(std::popcount(static_cast<unsigned>(cells_per_metre)) <= 2) {}

Result<Grid> Grid::create(int cells_per_metre) {
  if (cells_per_metre < 1 || cells_per_metre > kMaxCellsPerMetre) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{} cells a metre is not within 1..{}",
                                                    cells_per_metre, kMaxCellsPerMetre));
  }
  return Grid(cells_per_metre);
}

Grid Grid::standard() { return Grid(10); }

Result<VoxelIndex> Grid::voxel_at(const Eigen::Vector3d& p_ecef) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double scaled = p_ecef[axis] * cells_per_metre_;
    if (!(scaled >= -half_voxels_ && scaled < half_voxels_)) {  // NaN too.
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("ECEF {} = {} m is off the index cube, [-6400000, 6400000) m",
                              "xyz"[axis], p_ecef[axis]));
    }
  }
  return voxel_unchecked(p_ecef);
}

Result<TileKey> Grid::tile_at(const Eigen::Vector3d& p_ecef) const {
  auto voxel = voxel_at(p_ecef);
  if (!voxel) return pass_on(voxel);
  return tile_of(*voxel);
}

Eigen::Vector3d Grid::to_voxels(const Eigen::Vector3d& p_ecef) const {
  Eigen::Vector3d p_voxels;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = p_ecef[axis];
    const std::int32_t voxel = axis_voxel(x);
    const double lower = voxel;
    double v = x * cells_per_metre_ + half_voxels_;
    if (!product_exact_) {  // Counted from the voxel's own border, so that a border comes out
                            // whole.
      const double border = static_cast<double>(voxel - half_voxels_) / cells_per_metre_;
      v = lower + (x - border) * cells_per_metre_;
    }
    p_voxels[axis] = v < lower + 1 ? std::max(v, lower) : std::nextafter(lower + 1, lower);
  }
  return p_voxels;
}

bool Grid::holds(const VoxelIndex& voxel) const {
  return (voxel.array() >= 0).all() && (voxel.array() < 2 * half_voxels_).all();
}

TileKey Grid::tile_of(const VoxelIndex& voxel) const {
  VOX_CHECK(holds(voxel));
  return TileKey(morton_encode({static_cast<std::uint32_t>(voxel.x() >> kDepth),
                                static_cast<std::uint32_t>(voxel.y() >> kDepth),
                                static_cast<std::uint32_t>(voxel.z() >> kDepth)}));
}

Index3 Grid::in_tile(const VoxelIndex& voxel) {
  constexpr std::uint32_t kMask = kTileVoxels - 1;
  return {static_cast<std::uint32_t>(voxel.x()) & kMask,
          static_cast<std::uint32_t>(voxel.y()) & kMask,
          static_cast<std::uint32_t>(voxel.z()) & kMask};
}

VoxelIndex Grid::min_voxel(TileKey tile) {
  const Index3 index = tile.index();
  return VoxelIndex(static_cast<int>(index[0]), static_cast<int>(index[1]),
                    static_cast<int>(index[2])) *
         kTileVoxels;
}

Result<TileKey> Grid::tile_from_morton(std::uint64_t code) const {
  auto tile = TileKey::from_morton(code);
  if (!tile) return pass_on(tile);
  const Index3 index = tile->index();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (index[axis] >= tiles_per_axis_) {
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("tile key {:#x}: {} = {} is not below the grid's {} tiles an axis",
                              code, "xyz"[axis], index[axis], tiles_per_axis_));
    }
  }
  return tile;
}

Eigen::Vector3d Grid::min_corner(const VoxelIndex& voxel) const {
  return (voxel.array() - half_voxels_).cast<double>() / cells_per_metre_;
}

Box Grid::box(TileKey tile) const { return box(tile, CellKey{}); }

Box Grid::box(TileKey tile, CellKey cell) const {
  const Index3 in_tile = cell.min_voxel();
  const VoxelIndex lower =
      min_voxel(tile) + VoxelIndex(static_cast<int>(in_tile[0]), static_cast<int>(in_tile[1]),
                                   static_cast<int>(in_tile[2]));
  const VoxelIndex upper = lower.array() + static_cast<int>(cell.edge_voxels());
  return {.min = min_corner(lower), .max = min_corner(upper)};
}

}  // namespace voxatlas
