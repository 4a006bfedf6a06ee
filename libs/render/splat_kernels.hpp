#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/cell_key.hpp"
#include "render/camera.hpp"
#include "render/coverage.hpp"
#include "render/render_tree.hpp"

namespace voxatlas {

/// What the inner loops of the Splatter need to know of a camera. They count in voxels along the
/// grid's axes from the eye's own voxel, which no place on Earth makes large: a face of a cell is a
/// whole number, less the eye's place within its voxel, and so exact to 2^-24 of a voxel next to
/// the eye, where it matters.
struct SplatFrame {
  SplatFrame(const Camera& camera, const Grid& grid);

  /// The children of a node of depth - 1: their middles from its lower corner, in homogeneous
  /// pixels: pixel x is x / z; of a map, x is pixels already.
  struct Level {
    alignas(32) std::array<float, 8> x, y, z;
    float half;     ///< Of a cell's edge.
    float reach_z;  ///< From a cell's middle to its nearest corner along the camera's axis.
  };

  /// The pixels of a cube in a strip at x0, within `rect`: those between the outermost of its
  /// corners, where all are well ahead. What the kernels reckon is too wide for large cubes.
  PixelRect tightened(const std::array<std::int32_t, 3>& corner, int edge, const PixelRect& rect,
                      int x0) const;

  /// A ray along a face counts as this steep: 1 / it is finite, so that 0 times it is 0.
  static constexpr float kTinyRay = 1e-30f;

  int width, height;
  bool map;                                     ///< Orthographic.
  VoxelIndex eye;                               ///< The eye's voxel,
  std::array<float, 3> in_voxel;                ///< and where in it, 0..1.
  std::array<std::array<float, 3>, 3> project;  ///< Rows x, y, z: homogeneous pixels of a voxel.
  std::array<float, 2> offset;                  ///< Pixels that a map's places are moved by.
  std::array<Level, kDepth + 1> levels;
  /// Of pixel place (x, y): its ray is ray + x ray_dx + y ray_dy; a map's rays all are `ray`, and
  /// where they start is given in the same way.
  std::array<double, 3> ray, ray_dx, ray_dy;
  std::array<double, 3> start, start_dx, start_dy;
  std::array<float, 3> map_inverse;  ///< 1 / the ray that all of a map's pixels have.
  float near_z, far_z;               ///< Voxels along the camera's axis.
  float slack_pixels, slack_z;       ///< What rounding may do to a projection; see the .cpp.
  float steepest;  ///< A cell is projected where z - reach_z is above z * steepest.
  float voxel_metres;
};

/// A tile to draw.
struct SplatTile {
  std::array<std::int32_t, 3> corner{};  ///< Lower corner, voxels from the eye's voxel.
  const TreeLinks* links = nullptr;      ///< RenderTree::links().
  std::uint32_t first_number = 0;        ///< Of the root in the CellImage.
  int depth = kDepth;                    ///< Nodes of this depth are drawn whole.
};

/// A row of a strip's pixels.
struct SplatRow {
  /// By axis: 1 / the pixel's ray; of a map, where the ray starts.
  alignas(64) std::array<std::array<float, Coverage::kWidth>, 3> ray;
  std::array<std::uint32_t, Coverage::kWidth> cell;
  std::array<float, Coverage::kWidth> z;  ///< Metres.
};

/// A strip of the picture while it is drawn: columns x0 .. x0 + width - 1.
///
/// Cost: 20 bytes a pixel, to stay in a core's own cache.
struct SplatStrip {
  static constexpr int kBand = 8;  ///< Rows that are begun at once.

  int x0 = 0, width = 0;  ///< At most 64 columns.
  bool cull = true;       ///< Pass over what is covered. Off only to measure what that gains.
  Coverage coverage;
  std::vector<SplatRow> rows;  ///< Whole bands.
  /// A flag a band: whether anything came near it. If not, it shows nothing and holds anything: a
  /// picture is half sky, and a band's rays cost as much as some cells.
  std::vector<std::uint8_t> begun;

  void reset(const SplatFrame& frame, int first_column, int columns);
};

/// Draws tiles, nearest first, into a strip. The instructions are chosen at run time (Highway);
/// every choice gives the same bits: additions and multiplications stay apart, divisions are
/// rounded as IEEE says.
void splat(const SplatFrame& frame, std::span<const SplatTile> tiles, SplatStrip& strip);

}  // namespace voxatlas
