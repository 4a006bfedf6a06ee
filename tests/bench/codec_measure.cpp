#include <octomap/ColorOcTree.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>

#include "base/check.hpp"
#include "bench/codec_case.hpp"
#include "bench/import_case.hpp"
#include "codec/paper_format.hpp"
#include "codec/tile_codec.hpp"
#include "codec/zstd_frame.hpp"
#include "octree/brick_table.hpp"
#include "octree/octomap_bridge.hpp"

namespace voxatlas::bench {
namespace {

constexpr int kRounds = 9;

double mixed_bricks(const TileTree& tile) {
  if (tile.empty()) return 0;
  double count = 0;
  for (unsigned i = 0; i < kBricks; ++i) count += tile.bricks()->is_mixed(i) ? 1 : 0;
  return count;
}

/// The least of a few rounds: what a shared machine disturbs least.
double least_cpu(const std::function<void()>& work) {
  double least = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    const double start = cpu_seconds();
    work();
    least = std::min(least, cpu_seconds() - start);
  }
  return least;
}

double total(const std::vector<Bytes>& tiles) {
  double bytes = 0;
  for (const auto& tile : tiles) bytes += static_cast<double>(tile.size());
  return bytes;
}

std::vector<Bytes> encode_all(const CodecModel& model, const CodecOptions& options) {
  std::vector<Bytes> tiles;
  for (const auto& tile : model.tiles) tiles.push_back(encode_tile(tile, options));
  return tiles;
}

void decode_all(const std::vector<Bytes>& tiles, int depth) {
  for (const auto& tile : tiles) VOX_CHECK(decode_tile_to_depth(tile, depth).has_value());
}

/// What OctoMap's write and writeBinary make, without their " done." on standard error for each
/// tile; and writeBinary prunes, also what was expanded.
Bytes octomap_bytes(const TileTree& tile, bool binary, bool expanded) {
  const auto tree = to_octomap(tile, Grid::standard());
  if (expanded) tree->expand();
  if (binary && !expanded) {
    tree->toMaxLikelihood();
    tree->prune();
  }
  std::stringstream out;
  out << "# Octomap OcTree " << (binary ? "binary " : "") << "file\n"
      << "# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << "id " << tree->getTreeType() << "\nsize " << tree->size() << "\nres "
      << tree->getResolution() << "\ndata\n";
  binary ? tree->writeBinaryData(out) : tree->writeData(out);
  VOX_CHECK(out.good());
  const std::string text = out.str();
  return {text.begin(), text.end()};
}

void add_to(Figure8Row& row, const Bytes& bytes) {
  Bytes frame3, frame19;
  zstd_compress(bytes, 3, frame3);
  zstd_compress(bytes, 19, frame19);
  row.bytes += static_cast<double>(bytes.size());
  row.zstd3 += static_cast<double>(frame3.size());
  row.zstd19 += static_cast<double>(frame19.size());
}

Figure8Row row_of(const std::string& name, const CodecModel& model,
                  const std::function<Bytes(const TileTree&)>& encode) {
  Figure8Row row{name};
  for (const auto& tile : model.tiles) add_to(row, encode(tile));
  return row;
}

Figure8Row points_row(const CodecModel& model) {
  Figure8Row row{"points"};
  for (const auto& scan : model.scans) add_to(row, scan);
  return row;
}

double discrepancy(const TileTree& tile, const PaperOptions& options) {
  double sum = 0, voxels = 0;
  tile.for_each_leaf([&](const Leaf& leaf) {
    const double weight = std::exp2(3 * (kDepth - leaf.cell.depth));
    const double p = paper_quantized(to_probability(leaf.state.log_odds), options);
    sum += weight * std::abs(std::log(p / (1 - p)) - to_float_log_odds(leaf.state.log_odds));
    voxels += weight;
  });
  return sum / voxels;
}

}  // namespace

CodecFigures measure_codecs(const CodecModel& model) {
  CodecFigures figures;
  for (const auto& tile : model.tiles) {
    const auto counts = tile.counts();
    figures.memory += mixed_bricks(tile) * sizeof(Brick);
    figures.nodes += static_cast<double>(counts.leaves + counts.inner);
    figures.occupied += static_cast<double>(counts.occupied_voxels);
  }
  std::vector<Bytes> fast, dense;
  figures.fast_encode = least_cpu([&] { fast = encode_all(model, {TileCodec::kFast}); });
  figures.dense_encode = least_cpu([&] { dense = encode_all(model, {TileCodec::kDense}); });
  figures.fast_decode = least_cpu([&] { decode_all(fast, kDepth); });
  for (int depth = 0; depth <= kDepth; ++depth) {
    figures.to_depth[depth] = least_cpu([&] { decode_all(dense, depth); });
  }
  figures.dense_decode = figures.to_depth[kDepth];
  for (int depth = 0; depth <= kDepth; ++depth) {
    for (const auto& tile : model.tiles) {
      figures.cut[depth] +=
          static_cast<double>(encode_tile(cut_tile(tile, depth), {TileCodec::kDense}).size());
    }
  }
  figures.fast = total(fast);
  figures.dense = total(dense);
  figures.lossy6 = total(encode_all(model, {TileCodec::kLossy, 0, {6, 5}}));
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    VOX_CHECK(decode_tile(dense[i]).value() == model.tiles[i]);
    VOX_CHECK(decode_tile(fast[i]).value() == model.tiles[i]);
  }
  return figures;
}

double octomap_zstd19(const CodecModel& model) {
  return row_of("", model, [](const TileTree& tile) { return octomap_bytes(tile, false, false); })
      .zstd19;
}

std::vector<Figure8Row> figure_8(const CodecModel& model) {
  std::vector<Figure8Row> rows;
  if (!model.scans.empty()) rows.push_back(points_row(model));
  const std::pair<const char*, PaperOptions> papers[] = {
      {"paper raw", {PaperFormat::kRaw}},
      {"paper lossless", {PaperFormat::kLossless}},
      {"paper lossy, 9 bits", {PaperFormat::kLossy, 9, 8}}};
  for (const bool expanded : {true, false}) {
    const std::string when = expanded ? ", unpruned" : "";
    for (const auto& [name, options] : papers) {
      rows.push_back(row_of(name + when, model, [&, &how = options](const TileTree& tile) {
        return encode_paper(tile, how, expanded);
      }));
    }
    for (const bool binary : {false, true}) {
      rows.push_back(
          row_of((binary ? "OctoMap .bt" : "OctoMap .ot") + when, model,
                 [&](const TileTree& tile) { return octomap_bytes(tile, binary, expanded); }));
    }
  }
  // A tile's own bytes do not depend on whether it was pruned: bricks are.
  const std::pair<const char*, CodecOptions> ours[] = {
      {"voxatlas fast", {TileCodec::kFast}},
      {"voxatlas dense", {TileCodec::kDense}},
      {"voxatlas lossy, 9 bits", {TileCodec::kLossy, 0, {9, 8}}},
      {"voxatlas lossy, 6 bits", {TileCodec::kLossy, 0, {6, 5}}}};
  for (const auto& [name, options] : ours) {
    rows.push_back(row_of(
        name, model, [&how = options](const TileTree& tile) { return encode_tile(tile, how); }));
  }
  return rows;
}

CodecModel representative(const CodecModel& model) {
  const TileTree* best = &model.tiles.front();
  std::size_t most = 0;
  for (const auto& tile : model.tiles) {
    std::set<LogOdds> values;
    tile.for_each_leaf([&](const Leaf& leaf) { values.insert(leaf.state.log_odds); });
    if (values.size() <= most) continue;
    most = values.size();
    best = &tile;
  }
  return {{*best}, {}};
}

std::vector<Figure7Row> figure_7(const CodecModel& model) {
  const TileTree tile = representative(model).tiles.front();
  std::vector<Figure7Row> rows;
  for (int bits = 1; bits <= 32; ++bits) {
    PaperOptions options{PaperFormat::kLossy, bits, 8, PaperQuantizer::kClamps};
    Figure7Row row{bits, discrepancy(tile, options), 0};
    options.quantizer = PaperQuantizer::kUnit;
    row.unit = discrepancy(tile, options);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace voxatlas::bench
