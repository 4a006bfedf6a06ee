#pragma once

#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// The serialised nodes of the paper's section 5.1, bit for bit, to measure its figures again.
enum class PaperFormat : std::uint8_t {
  kRaw = 1,          ///< Every node: 32 bits of probability, 24 of colour, 8 of child array.
  kLossless = 2,     ///< Leaf bit; child array only in inner nodes, payload only in leaves.
  kInnerColour = 3,  ///< As lossless, but inner nodes keep their colour.
  kLossy = 4,        ///< As lossless, with quantised payload.
};

/// The two ways to read "quantised to b bits" (sections 5.1 and 7.1).
enum class PaperQuantizer : std::uint8_t {
  kClamps = 1,  ///< 2^b levels from P(clamp_min) to P(clamp_max), the nearest.
  kUnit = 2,    ///< 2^b equal bins of [0, 1], the middle of the bin.
};

struct PaperOptions {
  PaperFormat format = PaperFormat::kLossless;
  int bits = 32;        ///< Of a lossy probability, 1..32.
  int colour_bits = 8;  ///< Of a lossy colour channel, 1..8.
  PaperQuantizer quantizer = PaperQuantizer::kClamps;
  SensorModel model = SensorModel::standard();  ///< Its clamps: what kClamps spans.
};

/// Bits of the nodes alone, header excluded, as the paper counts them. The paper's 15.6 % keeps the
/// inner colour, its 91.4 % and 80.5 % do not and have 1 bit a channel, although 7.1 says 8.
std::uint64_t paper_bits(const TileTree::Counts& counts, const PaperOptions& options);

/// The tile's canonical octree: a header, then nodes depth first, children 0..7, bits from the
/// highest down. FORMAT.md, "paper". Probability is a float (raw, lossless) or a level; a colour
/// is 8 bits a channel and one seen once; white, as in OctoMap, is none, and free cells have none.
/// `expanded`: every leaf as its voxels, the full tree below each known cell ("unpruned").
Bytes encode_paper(const TileTree& tree, const PaperOptions& options, bool expanded = false);

/// Errors: kCorrupt for bytes that encode_paper does not write. Memory: bounded by one tile.
Result<TileTree> decode_paper(ByteView bytes);

/// What a probability becomes in b bits and back: figure 7. In double, unlike a tile's lattice, so
/// that 32 bits differ from 20.
double paper_quantized(double probability, const PaperOptions& options);

}  // namespace voxatlas
