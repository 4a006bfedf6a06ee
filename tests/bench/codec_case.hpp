#pragma once

#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::bench {

/// A whole model, and the points it was made of.
struct CodecModel {
  std::vector<TileTree> tiles;
  std::vector<Bytes> scans;  ///< Each one's points: three floats, relative to the sensor.
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
  double cut[8] = {};  ///< Bytes of dense tiles cut at a depth.
  double fast_encode = 0, fast_decode = 0, dense_encode = 0, dense_decode = 0;
  double to_depth[8] = {};  ///< Decoding dense tiles to a depth.
};
CodecFigures measure_codecs(const CodecModel& model);
/// Bytes of OctoMap's .ot of each tile with Zstandard 19.
double octomap_zstd19(const CodecModel& model);

/// One row of figure 8: bytes as they are, and each tile (or scan) with Zstandard 3 and 19.
struct Figure8Row {
  std::string name;
  double bytes = 0, zstd3 = 0, zstd19 = 0;
};
std::vector<Figure8Row> figure_8(const CodecModel& model);

/// The tile with representative features, the one with most different log-odds, as a model.
CodecModel representative(const CodecModel& model);

/// Mean discrepancy of log-odds for 1..32 bits, over the voxels of the representative tile: levels
/// between the clamps, and bins of [0, 1].
struct Figure7Row {
  int bits = 0;
  double clamps = 0, unit = 0;
};
std::vector<Figure7Row> figure_7(const CodecModel& model);

}  // namespace voxatlas::bench
