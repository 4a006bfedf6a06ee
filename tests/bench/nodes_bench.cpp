// The paper's figures 3, 4 and 5: one tile's occupied and free cells, shares of nodes a layer, bits
// a node.
//
// Prints lines `name value unit`: of a full octree of depth 7, as the paper counts, and of the
// model of the simulated drive, or with --data of real scans. With --out also figure 3 as PNGs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/check.hpp"
#include "bench/render_model.hpp"
#include "codec/paper_format.hpp"
#include "geodesy/ecef.hpp"
#include "render/painter.hpp"

namespace voxatlas::bench {
namespace {

constexpr int kFreeDepth = 4;

struct Layers {
  std::array<double, kDepth + 1> leaves{}, inner{};
};

Layers full_tree() {
  Layers layers;
  for (int depth = 0; depth <= kDepth; ++depth) {
    (depth < kDepth ? layers.inner : layers.leaves)[static_cast<std::size_t>(depth)] =
        std::exp2(3 * depth);
  }
  return layers;
}

/// Leaves come in Morton order, so an inner cell is new where it differs from the last one.
void count(const TileTree& tile, Layers& layers) {
  std::array<std::int64_t, kDepth> last;
  last.fill(-1);
  tile.for_each_leaf([&](const Leaf& leaf) {
    layers.leaves[leaf.cell.depth] += 1;
    for (CellKey cell = leaf.cell; cell.depth > 0;) {
      cell = cell.parent();
      if (last[cell.depth] == cell.code) break;
      last[cell.depth] = cell.code;
      layers.inner[cell.depth] += 1;
    }
  });
}

void print_layers(const std::string& name, const Layers& layers) {
  double total = 0, leaves = 0;
  for (std::size_t depth = 0; depth <= kDepth; ++depth) {
    total += layers.leaves[depth] + layers.inner[depth];
    leaves += layers.leaves[depth];
  }
  for (std::size_t depth = 0; depth <= kDepth; ++depth) {
    fmt::print("{}_layer_{} {:.6g} share\n", name, depth,
               (layers.leaves[depth] + layers.inner[depth]) / total);
  }
  fmt::print("{0}_leaf_share {1:.6g} share\n{0}_nodes {2} nodes\n", name, leaves / total, total);
  TileTree::Counts counts;
  counts.leaves = static_cast<std::uint64_t>(leaves);
  counts.inner = static_cast<std::uint64_t>(total - leaves);
  const std::pair<const char*, PaperOptions> formats[] = {
      {"raw", {PaperFormat::kRaw}},
      {"lossless", {PaperFormat::kLossless}},
      {"inner_colour", {PaperFormat::kInnerColour}},
      {"lossy_1", {PaperFormat::kLossy, 1, 1}},
      {"lossy_9_1", {PaperFormat::kLossy, 9, 1}},
      {"lossy_9_8", {PaperFormat::kLossy, 9, 8}}};
  const auto raw = static_cast<double>(paper_bits(counts, formats[0].second));
  for (const auto& [format, options] : formats) {
    const auto bits = static_cast<double>(paper_bits(counts, options));
    fmt::print("{0}_{1}_bits_per_node {2:.6g} bits\n{0}_{1}_reduction {3:.6g} share\n", name,
               format, bits / total, 1 - bits / raw);
  }
}

/// The tile with most occupied voxels, from outside, above and to the side of it.
void draw_tile(const Model& model, const Grid& grid, const std::string& folder) {
  const auto most = std::max_element(model.begin(), model.end(), [](const auto& a, const auto& b) {
    return a.second.counts().occupied_voxels < b.second.counts().occupied_voxels;
  });
  const auto& [key, tile] = *most;
  const RenderTree tree(tile);
  const FreeCells free_cells(tile, kFreeDepth);
  const Box box = grid.box(key);
  const Eigen::Vector3d middle = (box.min + box.max) / 2;
  const Eigen::Vector3d up = up_at(middle);
  const Eigen::Vector3d side = up.unitOrthogonal();
  const Camera camera = or_throw(
      Camera::look_at(middle + 20 * side + 12 * up, middle, up, Lens::of_view(45, 900, 700)));
  Painter painter(2);
  Painting painting;
  const PlacedTree trees[] = {{key, &tree}};
  const PlacedFree free[] = {{key, &free_cells}};
  PaintOptions options;
  options.overlay.tile_boxes = true;
  or_throw(painter.paint(camera, grid, trees, options, painting));
  write_file(folder + "/tile_occupied.png", or_throw(encode_png(painting.image)));
  options.free = free;
  or_throw(painter.paint(camera, grid, trees, options, painting));
  write_file(folder + "/tile_free.png", or_throw(encode_png(painting.image)));
  const auto counts = tile.counts();
  fmt::print("tile_occupied_voxels {} voxels\ntile_free_voxels {} voxels\n", counts.occupied_voxels,
             counts.free_voxels);
  fmt::print("tile_occupied_leaves {} leaves\ntile_free_leaves {} leaves\n", counts.occupied_leaves,
             counts.free_leaves);
}

void run(const ModelSource& source, const std::string& out) {
  const Grid grid = Grid::standard();
  print_layers("full", full_tree());
  const Model model = make_model(source, grid);
  Layers layers;
  TileTree::Counts counted;  // The tile's own count: another way to the same sums.
  for (const auto& [key, tile] : model) {
    count(tile, layers);
    counted.leaves += tile.counts().leaves;
    counted.inner += tile.counts().inner;
  }
  VOX_CHECK(std::accumulate(layers.leaves.begin(), layers.leaves.end(), 0.0) ==
            static_cast<double>(counted.leaves));
  VOX_CHECK(std::accumulate(layers.inner.begin(), layers.inner.end(), 0.0) ==
            static_cast<double>(counted.inner));
  print_layers("model", layers);
  fmt::print("model_tiles {} tiles\n", model.size());
  if (!out.empty()) draw_tile(model, grid, out);
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::ModelSource source;
  source.speed = 8;
  source.azimuth_step_deg = 0.4;
  source.scans = 200;
  std::string out;
  CLI::App app{"Nodes a layer, bits a node, and one tile as a picture"};
  app.add_option("--data", source.data, "folder of scans in KITTI form; else simulated");
  app.add_option("--poses", source.poses, "its pose file");
  app.add_option("--scans", source.scans, "at most so many scans")->capture_default_str();
  app.add_option("--out", out, "folder for PNGs, which must exist");
  CLI11_PARSE(app, argc, argv);
  try {
    voxatlas::bench::run(source, out);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_nodes: {}\n", e.what());
    return 1;
  }
}
