#pragma once

#include <memory>
#include <span>
#include <string>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"
#include "render/free_cells.hpp"
#include "render/gl_context.hpp"
#include "render/image.hpp"

namespace voxatlas {

/// What is drawn over the cells of a picture, beside free space.
struct OverlayOptions {
  bool tile_boxes = false;  ///< The edges of the tiles drawn; what stands before them hides them.
  bool axes = false;        ///< ECEF's x, y and z as they lie, lower left.
  bool north = false;       ///< Which way is north, upper right.
  /// A bar of a round length, lower right: of a map to scale everywhere, else at the distance
  /// of what is seen in the middle of the picture, which is said beside it.
  bool scale = false;

  bool any() const { return tile_boxes || axes || north || scale; }
};

/// What it is drawn of.
struct OverlayScene {
  std::span<const TileKey> boxes;    ///< Tiles, where boxes are wanted.
  std::span<const PlacedFree> free;  ///< Of one depth: shown as translucent grey.
};

/// Draws over a picture what is geometry and no cells, through OpenGL.
///
/// Source:  the paper's figures 3 and 6a.
/// Free:    the faces that bound free space, in one grey that lets some 80 % through, and their
///          edges: equal greys give the same picture in whatever order they are drawn. Cells hide
///          what is behind them.
/// Threads: one at a time.
class Overlay {
 public:
  /// Errors: kUnavailable where there is no OpenGL.
  static Result<std::unique_ptr<Overlay>> create();

  /// `cells` is what `image` was shaded from, `camera` what it shows. Errors: GlContext's.
  Status draw(const Camera& camera, const Grid& grid, const OverlayScene& scene,
              const OverlayOptions& options, const CellImage& cells, Image& image);

 private:
  explicit Overlay(std::unique_ptr<GlContext> context) : context_(std::move(context)) {}

  std::unique_ptr<GlContext> context_;
  GlContext::Pixels pixels_;
};

}  // namespace voxatlas
