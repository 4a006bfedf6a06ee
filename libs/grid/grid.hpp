#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/result.hpp"
#include "grid/cell_key.hpp"
#include "grid/tile_key.hpp"

namespace voxatlas {

/// A voxel of the whole grid: voxels along each axis from the index cube's lower corner, 0 .. 2^28.
using VoxelIndex = Eigen::Vector3i;

/// An axis-parallel box in ECEF, metres; min <= max on every axis; the lower faces belong to it.
struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
};

/// The one integer lattice that says in which voxel, and so in which tile, a point lies.
///
/// Source:  the paper's sections 3.2 and 3.3; DESIGN: r_max = 1/k metres, k = 1..20 whole cells a
///          metre, 10 by default: l_tile = 128/k = 12.8 m, l_index = 12 800 km, 10^6 tiles an axis.
/// Frame:   ECEF (WGS 84), metres. The index cube is centred on the Earth's centre.
/// Borders: a voxel, and so a tile, owns its lower faces; the cube's upper faces are outside.
///          voxel = floor(x * k) + half: the double nearest n / 10 lands on voxel n exactly,
///          whereas (x + half) / 0.1 misplaces 36 % of the borders. x * k gives n back where k is
///          a sum of two powers of two (Kahan), so for 10; where it is not (7, 11, 13, 14, 15, 19)
///          one look at the border above mends what rounding took, and n / k lands on n too.
/// Errors:  kOutOfRange off the cube, for NaN and infinities, with the value in the message.
/// Cost:    a small value; safe to share between threads.
class Grid {
 public:
  /// Errors: kOutOfRange where cells_per_metre is not 1..20.
  [[nodiscard]] static Result<Grid> create(int cells_per_metre);
  /// The standard parametrisation, 10 cells a metre.
  static Grid standard();

  int cells_per_metre() const { return cells_per_metre_; }
  std::uint32_t tiles_per_axis() const { return tiles_per_axis_; }
  double tile_length() const { return static_cast<double>(kTileVoxels) / cells_per_metre_; }
  /// Edge of a cell at depth 0..7, metres.
  double cell_length(int depth) const { return tile_length() / (1 << depth); }

  [[nodiscard]] Result<VoxelIndex> voxel_at(const Eigen::Vector3d& p_ecef) const;
  [[nodiscard]] Result<TileKey> tile_at(const Eigen::Vector3d& p_ecef) const;
  /// The same without the checks, for points known to lie on the cube; any finite input below 2^30
  /// cells gives a value, on the cube or not.
  VoxelIndex voxel_unchecked(const Eigen::Vector3d& p_ecef) const {
    return {axis_voxel(p_ecef.x()), axis_voxel(p_ecef.y()), axis_voxel(p_ecef.z())};
  }
  /// The point in voxels, with its fraction, as Walk wants it: x * k + half, held inside the voxel
  /// that voxel_unchecked() gives (adding half rounds, and may round up to the next border).
  Eigen::Vector3d to_voxels(const Eigen::Vector3d& p_ecef) const;
  bool holds(const VoxelIndex& voxel) const;

  /// The tile of a voxel of this grid, and the voxel's place in it, each axis 0..127.
  TileKey tile_of(const VoxelIndex& voxel) const;
  static Index3 in_tile(const VoxelIndex& voxel);
  /// A tile's lowest voxel.
  static VoxelIndex min_voxel(TileKey tile);

  /// A key that came from outside. Errors: kOutOfRange where this grid has no such tile.
  [[nodiscard]] Result<TileKey> tile_from_morton(std::uint64_t code) const;

  /// The point with the smallest coordinates of a voxel, a tile, a cell; it lies in it.
  Eigen::Vector3d min_corner(const VoxelIndex& voxel) const;
  Eigen::Vector3d min_corner(TileKey tile) const { return min_corner(min_voxel(tile)); }
  Box box(TileKey tile) const;
  Box box(TileKey tile, CellKey cell) const;

  /// Half of the cube's edge in voxels: the offset between floor(x * k) and a VoxelIndex.
  std::int32_t half_voxels() const { return half_voxels_; }

  friend bool operator==(const Grid&, const Grid&) = default;

 private:
  explicit Grid(int cells_per_metre);

  std::int32_t axis_voxel(double x_ecef) const {
    const double scaled = x_ecef * cells_per_metre_;
    auto n = static_cast<std::int32_t>(scaled);  // Towards zero; one less is the floor below it.
    if (scaled < n) --n;
    if (!product_exact_ && static_cast<double>(n + 1) / cells_per_metre_ <= x_ecef) ++n;
    return n + half_voxels_;
  }

  int cells_per_metre_;
  std::uint32_t tiles_per_axis_;
  std::int32_t half_voxels_;
  bool product_exact_;  // (n / k) * k == n in double for every n.
};

}  // namespace voxatlas
