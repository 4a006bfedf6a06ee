#pragma once

#include <memory>
#include <span>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"
#include "render/gl_scene.hpp"
#include "render/tree_numbers.hpp"

namespace voxatlas {

/// Draws trees as the Splatter does, but through GlScene: the paper's own way, to compare with.
///
/// Cost: makes the clouds of each picture anew; bench_render measures GlScene without that.
/// Threads: one at a time.
class GlTrees {
 public:
  /// Errors: kUnavailable where there is no OpenGL.
  static Result<std::unique_ptr<GlTrees>> create();

  /// The numbers are those of TreeNumbers(trees). Errors: kOutOfRange for a depth outside 0..7, and
  /// GlScene's.
  Status draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees, int depth,
              CellImage& image);

 private:
  explicit GlTrees(std::unique_ptr<GlScene> scene) : scene_(std::move(scene)) {}

  std::unique_ptr<GlScene> scene_;
};

}  // namespace voxatlas
