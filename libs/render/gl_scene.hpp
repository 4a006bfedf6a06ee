#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_cloud.hpp"
#include "render/cell_image.hpp"
#include "render/gl_context.hpp"

namespace voxatlas {

/// Draws clouds of cells the paper's own way: a GL point for each, as large as the cell looks.
///
/// Source:  the paper's section 3.4. A point is a square of 1.5 projected cell edges, at least
///          2 pixels, so that a closed surface of cells has no holes; its depth is the cell's
///          middle. Cells that would make a point of more than kMaxPoint pixels, and those the near
///          plane cuts, are drawn as cubes instead: GL has no larger points and drops a point whose
///          middle is out of view. The picture is drawn with a margin for the same reason.
/// Frame:   each tile is placed relative to the camera in double, its cells in whole half voxels:
///          exact in float at any place on Earth.
/// Threads: one at a time.
class GlScene {
 public:
  static constexpr double kSplatScale = 1.5;
  static constexpr double kMinPoint = 2;   ///< Pixels.
  static constexpr double kMaxPoint = 48;  ///< Pixels.

  static Result<std::unique_ptr<GlScene>> create();

  /// Which cell each pixel shows; clouds nearest first draw fastest.
  /// Errors: kOutOfRange for 2^32 cells or more, and GlContext's.
  Result<CellImage> draw(const Camera& camera, const Grid& grid,
                         std::span<const PlacedCloud> clouds);

 private:
  explicit GlScene(std::unique_ptr<GlContext> context) : context_(std::move(context)) {}

  void number_up_to(std::uint64_t count);
  void draw_cloud(const Camera& camera, const Grid& grid, const PlacedCloud& placed,
                  std::uint32_t first_number);

  std::unique_ptr<GlContext> context_;
  std::vector<std::uint32_t> numbers_;  // numbers_[i] == i: the colours of points.
  GlContext::Pixels pixels_;
};

}  // namespace voxatlas
