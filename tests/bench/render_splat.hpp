#pragma once

#include <string>
#include <vector>

#include "bench/render_model.hpp"
#include "render/painter.hpp"

namespace voxatlas::bench {

struct View {
  std::string name;
  Camera camera;
};

/// Prints how long the Splatter takes, beside the GL backend in the same run: medians of `repeat`
/// pictures, and the best of them.
class SplatBench {
 public:
  SplatBench(const Model& model, const Grid& grid, int repeat);

  void print_memory() const;
  void print_coarse_build() const;
  /// One and two threads, and the whole picture as JPEG.
  void print_view(const View& view);
  /// What passing over the hidden gains, and what it would if it were known beforehand; and what a
  /// second thread gains.
  void print_gains(const View& street);
  /// Depth by depth, the paper's table 1 beside.
  void print_depths(const View& view);
  /// On two threads each, `_vs_gl`; by the processor time of both, `_vs_gl_processor`; and one
  /// thread of the splatter beside two of GL, `_1t_vs_gl`.
  void print_against_gl(const std::vector<View>& views);

  const std::vector<PlacedTree>& placed() const { return placed_; }

 private:
  void splat(Splatter& splatter, const Camera& camera, const SplatOptions& options);
  void jpeg_of(const View& view);

  const Model& model_;
  const Grid& grid_;
  int repeat_;
  std::vector<RenderTree> trees_;
  std::vector<PlacedTree> placed_;
  double build_ms_ = 0;
  Splatter alone_{1}, both_{2};
  Painter painter_{2};
  CellImage image_;
  Painting painting_;
};

}  // namespace voxatlas::bench
