#include "bench/render_splat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "base/utime.hpp"
#include "geodesy/ecef.hpp"
#include "render/frustum.hpp"
#include "render/picture.hpp"
#include "render/splatter.hpp"

namespace voxatlas::bench {
namespace {

/// The paper's table 1: frame times at depths 0..7, one thread, milliseconds.
constexpr std::array kPaper = {3, 9, 19, 47, 165, 804, 3402, 10820};
constexpr int kQuality = 60;
constexpr std::size_t kJpegBytes = 150'000;

struct View {
  std::string name;
  Camera camera;
};

double milliseconds(const std::function<void()>& work) {
  const std::int64_t start = steady_utime();
  work();
  return static_cast<double>(steady_utime() - start) / 1000;
}

double median(std::vector<double> times) {
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

/// Runs works in turns, so that what else the machine does falls on all of them alike.
std::vector<double> medians(int repeat, const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  for (int i = 0; i < repeat; ++i) {
    for (std::size_t w = 0; w < works.size(); ++w) times[w].push_back(milliseconds(works[w]));
  }
  std::vector<double> result;
  for (auto& each : times) result.push_back(median(std::move(each)));
  return result;
}

/// As the street view, but raised and turned down.
Camera raised(const Camera& street, double metres, double down_deg) {
  const Eigen::Vector3d up = up_at(street.position());
  const Eigen::Vector3d ahead = street.orientation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d level = (ahead - ahead.dot(up) * up).normalized();
  const double angle = down_deg * std::numbers::pi / 180;
  const Eigen::Vector3d eye = street.position() + metres * up;
  return or_throw(Camera::look_at(eye, eye + std::cos(angle) * level - std::sin(angle) * up, up,
                                  street.lens()));
}

class Trees {
 public:
  explicit Trees(const Model& model) {
    trees_.reserve(model.size());  // They must not move: placed_ points at them.
    for (const auto& [key, tile] : model) {
      const RenderTree& tree = trees_.emplace_back(tile);
      placed_.push_back({key, &tree});
      bytes_ += tree.memory_bytes();
      cells_ += tree.cell_count(kDepth);
    }
  }
  const std::vector<PlacedTree>& placed() const { return placed_; }
  std::size_t bytes() const { return bytes_; }
  std::uint64_t cells() const { return cells_; }

 private:
  std::vector<RenderTree> trees_;
  std::vector<PlacedTree> placed_;
  std::size_t bytes_ = 0;
  std::uint64_t cells_ = 0;
};

class SplatBench {
 public:
  SplatBench(const Model& model, const Grid& grid, int repeat)
      : model_(model), grid_(grid), repeat_(repeat), trees_(model) {}

  void print_memory() const {
    fmt::print(
        "occupied_cells {} cells\nrender_tree_memory {} bytes\nbytes_per_cell {:.2f} bytes\n",
        trees_.cells(), trees_.bytes(),
        static_cast<double>(trees_.bytes()) / static_cast<double>(trees_.cells()));
  }

  void print_view(const View& view) {
    const auto times =
        medians(repeat_, {[&] { splat(alone_, view.camera, {}); },
                          [&] { splat(both_, view.camera, {}); }, [&] { jpeg_of(view); }});
    fmt::print(
        "{0}_1t_splat_ms {1:.2f} ms\n{0}_2t_splat_ms {2:.2f} ms\n{0}_2t_jpeg_ms {3:.2f} ms\n",
        view.name, times[0], times[1], times[2]);
  }

  void print_street(const View& street) {
    const auto times = medians(repeat_, {[&] { splat(alone_, street.camera, {}); },
                                         [&] {
                                           splat(alone_, street.camera, {kDepth, 0, false});
                                         },
                                         [&] { splat(both_, street.camera, {}); }});
    fmt::print("occlusion_gain {:.2f} x\nthreads2_speedup {:.2f} x\n", times[1] / times[0],
               times[0] / times[2]);
    std::vector<std::function<void()>> by_depth;
    for (int depth = 0; depth <= kDepth; ++depth) {
      by_depth.push_back([&, depth] { splat(alone_, street.camera, {depth, 0, true}); });
    }
    const auto depths = medians(repeat_, by_depth);
    for (std::size_t depth = 0; depth < depths.size(); ++depth) {
      fmt::print("depth{0}_ms {1:.2f} ms\ndepth{0}_paper {2} ms\n", depth, depths[depth],
                 kPaper[depth]);
    }
  }

  void print_against_gl(const std::vector<View>& views) {
    std::map<TileKey, CellCloud> clouds;
    for (const auto& [key, tile] : model_) clouds.emplace(key, CellCloud(tile, kDepth));
    const auto gl = or_throw(GlScene::create());
    for (const View& view : views) {
      std::vector<TileKey> keys;
      for (const auto& [key, cloud] : clouds) keys.push_back(key);
      std::vector<PlacedCloud> placed;
      std::size_t cells = 0;
      for (const TileKey key : tiles_in_view(view.camera, grid_, keys)) {
        placed.push_back({key, &clouds.at(key)});
        cells += placed.back().cloud->cells().size();
      }
      const auto times = medians(std::min(repeat_, kGlRepeat),
                                 {[&] { splat(alone_, view.camera, {}); },
                                  [&] { or_throw(gl->draw(view.camera, grid_, placed)); }});
      fmt::print("{0}_gl_ms {1:.1f} ms\n{0}_gl_cells {2} cells\n{0}_vs_gl {3:.2f} x\n", view.name,
                 times[1], cells, times[1] / times[0]);
    }
  }

  Image picture(const View& view) {
    splat(both_, view.camera, {});
    const TreeNumbers numbers(trees_.placed());
    return shade(image_, numbers, view.camera, grid_,
                 scene_heights(view.camera, grid_, trees_.placed()), Colouring::kRgb,
                 both_.workers());
  }

 private:
  static constexpr int kGlRepeat = 5;  // A second each.

  void splat(Splatter& splatter, const Camera& camera, const SplatOptions& options) {
    or_throw(splatter.draw(camera, grid_, trees_.placed(), options, image_));
  }
  void jpeg_of(const View& view) { or_throw(encode_jpeg(picture(view), kQuality, kJpegBytes)); }

  const Model& model_;
  const Grid& grid_;
  int repeat_;
  Trees trees_;
  Splatter alone_{1}, both_{2};
  CellImage image_;
};

}  // namespace

void measure_splatter(const Model& model, const Grid& grid, const Camera& street, int repeat,
                      const std::string& out) {
  const std::vector<View> views = {
      {"street", street}, {"oblique", raised(street, 20, 20)}, {"aerial", raised(street, 65, 43)}};
  SplatBench bench(model, grid, repeat);
  bench.print_memory();
  for (const View& view : views) {
    bench.print_view(view);
    if (out.empty()) continue;
    write_file(std::filesystem::path(out) / ("splat_" + view.name + ".png"),
               or_throw(encode_png(bench.picture(view))));
  }
  bench.print_street(views[0]);
  bench.print_against_gl(views);
}

}  // namespace voxatlas::bench
