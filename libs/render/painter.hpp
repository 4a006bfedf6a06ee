#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"
#include "render/free_cells.hpp"
#include "render/gl_trees.hpp"
#include "render/image.hpp"
#include "render/overlay.hpp"
#include "render/shade.hpp"
#include "render/splatter.hpp"
#include "render/tree_numbers.hpp"

namespace voxatlas {

/// Who finds out which cell each pixel shows.
enum class Backend {
  kSplat,  ///< Splatter.
  kGl,     ///< GlTrees, the paper's way: slower, not exact; no threshold.
};
/// "splat", "gl".
const char* name_of(Backend backend);
/// Errors: kInvalid, naming the word and the choice.
Result<Backend> backend_of(const std::string& name);

struct PaintOptions {
  SplatOptions splat;  ///< Depth 0..7 at most, and the threshold of pixels.
  Colouring colouring = Colouring::kRgb;
  bool fill_holes = false;           ///< For models that are sparse: scans seen from afar.
  OverlayOptions overlay;            ///< Boxes are those of the tiles drawn.
  std::span<const PlacedFree> free;  ///< Free space to show through, all of one depth.
  Backend backend = Backend::kSplat;
};

/// A picture and what it took.
struct Painting {
  Image image;
  CellImage cells;        ///< What it was shaded from: which cell, and z, the depth image.
  int depth = 0;          ///< The deepest at which a tile was drawn.
  std::size_t tiles = 0;  ///< Drawn: in view and not empty.
  std::uint64_t cells_in_view = 0;  ///< That those have, at the depths drawn.
  double draw_ms = 0;               ///< The backend,
  double shade_ms = 0;              ///< light, colour and sky,
  double overlay_ms = 0;            ///< what is drawn over it.
};

/// Draws and shades trees: all stages of a picture but fetching and encoding.
///
/// Trees:   in any order; the numbers in `cells` are those of TreeNumbers(trees). Heights of the
///          ground and of the scene are taken from those in view, so trees out of view change
///          nothing.
/// Result:  the same bits whatever the number of threads; a refined picture without threshold is
///          the same as one that never had a budget.
/// Threads: one at a time; it keeps its own workers.
class Painter {
 public:
  explicit Painter(std::size_t threads) : splatter_(threads) {}

  /// Writes over `painting`, whose memory is used again.
  /// Errors: Splatter::draw's; kUnavailable where the overlay, free space or the gl backend are
  ///         wanted and there is no OpenGL; kInvalid for free space of several depths.
  Status paint(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
               const PaintOptions& options, Painting& painting);

  Workers& workers() { return splatter_.workers(); }  ///< For encoding, between pictures.

 private:
  Status draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
              const PaintOptions& options, Painting& painting);
  Status draw_over(const Camera& camera, const Grid& grid, std::span<const PlacedTree> in_view,
                   const PaintOptions& options, Painting& painting);

  Splatter splatter_;
  std::unique_ptr<GlTrees> gl_;       // Made when first wanted,
  std::unique_ptr<Overlay> overlay_;  // as this is.
};

}  // namespace voxatlas
