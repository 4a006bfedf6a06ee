#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::bench {

/// A whole model, and the points it was made of.
struct CodecModel {
  std::vector<TileTree> tiles;
  double points = 0;
};

/// Free space at 80 cm, surfaces at 10 cm, the default sensor model.
Result<CodecModel> real_model(const std::string& folder, const std::string& poses,
                              std::size_t scans);
/// With the colours that the simulated scanner sees, or without.
Result<CodecModel> simulated_model(std::size_t scans, bool coloured);

/// Sums over all tiles, bytes and seconds of processor time.
struct CodecFigures {
  double memory = 0;  ///< 1088 bytes a mixed brick.
  double nodes = 0, occupied = 0;
  double fast = 0, dense = 0, lossy6 = 0;
  double fast_encode = 0, fast_decode = 0, dense_encode = 0, dense_decode = 0;
  double to_depth[8] = {};  ///< Decoding dense tiles to a depth.
};
CodecFigures measure_codecs(const CodecModel& model);

/// One row of figure 8: bytes as they are, and each tile with Zstandard 3 and 19 (0: not made).
struct Figure8Row {
  std::string name;
  double bytes = 0, zstd3 = 0, zstd19 = 0;
};
std::vector<Figure8Row> figure_8(const CodecModel& model);

/// Mean discrepancy of log-odds for 1..32 bits, over the voxels of the tile with most different
/// log-odds: levels between the clamps, and bins of [0, 1].
struct Figure7Row {
  int bits = 0;
  double clamps = 0, unit = 0;
};
std::vector<Figure7Row> figure_7(const CodecModel& model);

}  // namespace voxatlas::bench
