#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_image.hpp"
#include "render/splat_kernels.hpp"
#include "render/tree_numbers.hpp"
#include "render/workers.hpp"

namespace voxatlas {

struct SplatOptions {
  int max_depth = kDepth;  ///< No cell deeper than this is drawn, 0..7.
  /// A tile is drawn at the first depth whose cells, at its nearest corner, are at most so many
  /// pixels wide. 0: always at max_depth.
  double pixel_threshold = 0;
  bool cull = true;  ///< Pass over what is hidden. It changes no pixel; off only to measure it.
};

/// Draws trees on the CPU: front to back, each pixel once.
///
/// Source:  the paper's section 3.4; DESIGN section 9.
/// Result:  a pixel shows the first cell that the ray through its middle meets between near and
/// far,
///          and where it enters it (near_range, where the ray starts inside): exact silhouettes, no
///          holes. The numbers are those of TreeNumbers. The same picture whatever the number of
///          threads and the processor's instructions, and in whatever order the trees come.
/// Threads: one at a time; it keeps its own workers.
class Splatter {
 public:
  explicit Splatter(std::size_t threads);

  /// Errors: kOutOfRange for a max_depth outside 0..7, a threshold that is negative or NaN, and
  ///         2^32 nodes or more.
  Status draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
              const SplatOptions& options, CellImage& image);

  /// What the last draw() drew.
  struct Drawn {
    int depth = 0;            ///< The deepest at which a tile was drawn.
    std::size_t tiles = 0;    ///< In view and not empty.
    std::uint64_t cells = 0;  ///< That these have, at the depths drawn.
  };
  const Drawn& drawn() const { return drawn_; }

  Workers& workers() { return workers_; }  ///< For the stages that follow, between draws.

 private:
  Drawn drawn_;
  Workers workers_;
  std::vector<SplatStrip> strips_;  // One a worker.
};

}  // namespace voxatlas
