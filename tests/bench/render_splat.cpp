#include "bench/render_splat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>

#include "base/utime.hpp"
#include "render/frustum.hpp"
#include "render/gl_scene.hpp"

namespace voxatlas::bench {
namespace {

/// The paper's table 1: frame times at depths 0..7, one thread, 100 m, milliseconds.
constexpr std::array kPaper = {3, 9, 19, 47, 165, 804, 3402, 10820};
constexpr int kQuality = 60;
constexpr std::size_t kJpegBytes = 150'000;
constexpr int kGlRepeat = 10;

/// Milliseconds: medians, and the best by the clock.
struct Times {
  double median, best;
  double processor;  ///< Of all threads: what a busy machine does not make longer.
};

double middle_of(std::vector<double> times) {
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

double processor_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double milliseconds(const std::function<void()>& work) {
  const std::int64_t start = steady_utime();
  work();
  return static_cast<double>(steady_utime() - start) / 1000;
}

/// Runs works in turns, so that what else the machine does falls on all of them alike.
std::vector<Times> measure(int repeat, const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size()), processor(works.size());
  for (int i = 0; i < repeat; ++i) {
    for (std::size_t w = 0; w < works.size(); ++w) {
      const double before = processor_ms();
      times[w].push_back(milliseconds(works[w]));
      processor[w].push_back(processor_ms() - before);
    }
  }
  std::vector<Times> result;
  for (std::size_t w = 0; w < works.size(); ++w) {
    result.push_back({middle_of(times[w]), *std::min_element(times[w].begin(), times[w].end()),
                      middle_of(processor[w])});
  }
  return result;
}

void print_ms(const std::string& name, const Times& times) {
  fmt::print("{0}_ms {1:.2f} ms\n{0}_best_ms {2:.2f} ms\n{0}_processor_ms {3:.2f} ms\n", name,
             times.median, times.best, times.processor);
}

/// What a picture shows and nothing else: all that a splatter would have to draw that knew
/// beforehand what is hidden.
class SeenAlone {
 public:
  SeenAlone(const Model& model, std::span<const PlacedTree> trees, const CellImage& picture) {
    std::vector<std::uint32_t> seen = picture.cell;
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    const TreeNumbers numbers(trees);
    std::map<TileKey, TileTree> tiles;
    for (const std::uint32_t number : seen) {
      if (number == CellImage::kNone) continue;
      const auto found = numbers.find(number);
      const PlacedTree& placed = trees[found.tree];
      const CellKey cell = placed.tree->key_of(found.node);
      tiles[placed.key].set(cell, *model.at(placed.key).cell(cell));
      ++cells_;
    }
    trees_.reserve(tiles.size());  // They must not move: placed_ points at them.
    for (const auto& [key, tile] : tiles) placed_.push_back({key, &trees_.emplace_back(tile)});
  }

  std::span<const PlacedTree> placed() const { return placed_; }
  std::size_t cells() const { return cells_; }

 private:
  std::vector<RenderTree> trees_;
  std::vector<PlacedTree> placed_;
  std::size_t cells_ = 0;
};

}  // namespace

SplatBench::SplatBench(const Model& model, const Grid& grid, int repeat)
    : model_(model), grid_(grid), repeat_(repeat) {
  trees_.reserve(model.size());  // They must not move: placed_ points at them.
  const std::int64_t start = steady_utime();
  for (const auto& [key, tile] : model) placed_.push_back({key, &trees_.emplace_back(tile)});
  build_ms_ = static_cast<double>(steady_utime() - start) / 1000;
}

void SplatBench::print_memory() const {
  std::size_t bytes = 0, cells = 0;
  for (const RenderTree& tree : trees_) {
    bytes += tree.memory_bytes();
    cells += tree.cell_count(kDepth);
  }
  const auto count = static_cast<double>(cells);
  fmt::print("tiles {} tiles\noccupied_cells {} cells\nbytes_per_cell {:.2f} bytes\n",
             trees_.size(), cells, static_cast<double>(bytes) / count);
  fmt::print("tree_build_ms {:.3f} ms\ntree_build_ns_per_cell {:.0f} ns\n",
             build_ms_ / static_cast<double>(trees_.size()), build_ms_ * 1e6 / count);
}

void SplatBench::print_coarse_build() const {
  const std::size_t every = model_.size() / 500 + 1;
  std::size_t built = 0, index = 0;
  const double ms = milliseconds([&] {
    for (const auto& [key, tile] : model_) {
      if (index++ % every == 0) built += RenderTree(tile, 0, kBrickDepth).empty() ? 0 : 1;
    }
  });
  fmt::print("coarse_build_ms {:.3f} ms\n",
             ms / static_cast<double>(std::max<std::size_t>(built, 1)));
}

void SplatBench::print_view(const View& view) {
  const auto times =
      measure(repeat_, {[&] { splat(alone_, view.camera, {}); },
                        [&] { splat(both_, view.camera, {}); }, [&] { jpeg_of(view); }});
  print_ms(view.name + "_1t_splat", times[0]);
  print_ms(view.name + "_2t_splat", times[1]);
  print_ms(view.name + "_2t_jpeg", times[2]);
  fmt::print("{}_cells_in_view {} cells\n", view.name, alone_.drawn().cells);
}

void SplatBench::print_gains(const View& street) {
  splat(alone_, street.camera, {});
  const SeenAlone seen(model_, placed_, image_);
  const auto times = measure(
      repeat_, {[&] { splat(alone_, street.camera, {}); },
                [&] {
                  splat(alone_, street.camera, {kDepth, 0, false});
                },
                [&] { splat(both_, street.camera, {}); },
                [&] { or_throw(alone_.draw(street.camera, grid_, seen.placed(), {}, image_)); }});
  fmt::print(
      "occlusion_gain {:.2f} x\nocclusion_gain_at_most {:.2f} x\nstreet_cells_seen {} cells\n",
      times[1].median / times[0].median, times[1].median / times[3].median, seen.cells());
  fmt::print("threads2_speedup {:.2f} x\nthreads2_best_speedup {:.2f} x\n",
             times[0].median / times[2].median, times[0].best / times[2].best);
}

void SplatBench::print_depths(const View& view) {
  std::vector<std::function<void()>> by_depth;
  for (int depth = 0; depth <= kDepth; ++depth) {
    by_depth.push_back([this, &view, depth] { splat(alone_, view.camera, {depth, 0, true}); });
  }
  const auto depths = measure(repeat_, by_depth);
  for (std::size_t depth = 0; depth < depths.size(); ++depth) {
    fmt::print("depth{0}_ms {1:.2f} ms\ndepth{0}_paper_ms {2} ms\n", depth, depths[depth].median,
               kPaper[depth]);
  }
}

void SplatBench::print_against_gl(const std::vector<View>& views) {
  // Mesa takes all processors; the splatter has two threads.
  setenv("LP_NUM_THREADS", "2", 1);
  const auto gl = or_throw(GlScene::create());
  for (const View& view : views) {
    std::vector<TileKey> keys;
    for (const auto& [key, tile] : model_) keys.push_back(key);
    std::map<TileKey, CellCloud> clouds;  // Made beforehand, as the trees are.
    std::vector<PlacedCloud> placed;
    std::size_t cells = 0;
    for (const TileKey key : tiles_in_view(view.camera, grid_, keys)) {
      const CellCloud& cloud = clouds.emplace(key, CellCloud(model_.at(key), kDepth)).first->second;
      placed.push_back({key, &cloud});
      cells += cloud.cells().size();
    }
    const auto times =
        measure(std::min(repeat_, kGlRepeat),
                {[&] { splat(alone_, view.camera, {}); }, [&] { splat(both_, view.camera, {}); },
                 [&] { or_throw(gl->draw(view.camera, grid_, placed)); }});
    const Times &one = times[0], &two = times[1], &points = times[2];
    fmt::print("{0}_gl_ms {1:.1f} ms\n{0}_gl_processor_ms {2:.1f} ms\n{0}_gl_cells {3} cells\n",
               view.name, points.median, points.processor, cells);
    fmt::print("{0}_vs_gl {1:.2f} x\n{0}_vs_gl_processor {2:.2f} x\n{0}_1t_vs_gl {3:.2f} x\n",
               view.name, points.median / two.median, points.processor / one.processor,
               points.median / one.median);
  }
}

void SplatBench::splat(Splatter& splatter, const Camera& camera, const SplatOptions& options) {
  or_throw(splatter.draw(camera, grid_, placed_, options, image_));
}

void SplatBench::jpeg_of(const View& view) {
  or_throw(painter_.paint(view.camera, grid_, placed_, {}, painting_));
  or_throw(encode_jpeg(painting_.image, kQuality, kJpegBytes, &painter_.workers()));
}

}  // namespace voxatlas::bench
