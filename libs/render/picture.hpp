#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/result.hpp"
#include "render/gl_scene.hpp"
#include "render/image.hpp"
#include "render/shade.hpp"

namespace voxatlas {

struct PictureOptions {
  Colouring colouring = Colouring::kRgb;
  bool fill_holes = true;
};

/// A finished picture and what it took.
struct Picture {
  Image image;
  CellImage cells;  ///< What it was shaded from.
  std::uint64_t cells_drawn = 0;
  double draw_ms = 0;
  double shade_ms = 0;
};

/// Draws and shades: all stages of a picture but fetching and encoding.
///
/// Threads: one at a time.
class PictureMaker {
 public:
  static Result<std::unique_ptr<PictureMaker>> create();

  /// Errors: GlScene's.
  Result<Picture> make(const Camera& camera, const Grid& grid, std::span<const PlacedCloud> clouds,
                       const PictureOptions& options);

 private:
  explicit PictureMaker(std::unique_ptr<GlScene> scene) : scene_(std::move(scene)) {}

  std::unique_ptr<GlScene> scene_;
};

}  // namespace voxatlas
