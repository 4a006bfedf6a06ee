// How long pictures take, depth by depth, and the pictures themselves.
//
//   bench_render [--data DIR --poses FILE] [--scans N] [--out DIR]
//
// Integrates scans, in KITTI form or of the simulated drive, and draws a street view, one from 20 m
// above it and one from 65 m: the median of several pictures a line, as "name value unit", beside
// the paper's table 1 and the GL backend. With --out also the GL backend depth by depth, and PNGs
// to look at.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>

#include "base/utime.hpp"
#include "bench/render_model.hpp"
#include "bench/render_splat.hpp"
#include "render/frustum.hpp"
#include "render/picture.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas {
namespace {

struct Options {
  bench::ModelSource source;
  std::string out, colouring = "rgb";
  int repeat = 20, gl_repeat = 5;
  int width = 1280, height = 720;
};

using bench::Model;
using bench::or_throw;

struct Timing {
  double draw_ms, shade_ms;
};

class Clouds {
 public:
  Clouds(const Model& model, int depth) {
    const std::int64_t start = steady_utime();
    for (const auto& [key, tree] : model) clouds_.emplace(key, CellCloud(tree, depth));
    build_ms_ = static_cast<double>(steady_utime() - start) / 1000;
  }

  std::vector<PlacedCloud> in_view(const Camera& camera, const Grid& grid) const {
    std::vector<TileKey> keys;
    for (const auto& [key, cloud] : clouds_) keys.push_back(key);
    return placed(tiles_in_view(camera, grid, keys));
  }
  std::vector<PlacedCloud> placed(const std::vector<TileKey>& keys) const {
    std::vector<PlacedCloud> placed;
    for (const TileKey key : keys) placed.push_back({key, &clouds_.at(key)});
    return placed;
  }
  double build_ms() const { return build_ms_; }
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& [key, cloud] : clouds_) sum += cloud.memory_bytes();
    return sum;
  }

 private:
  std::map<TileKey, CellCloud> clouds_;
  double build_ms_ = 0;
};

Timing median(std::vector<Timing> timings) {
  std::sort(timings.begin(), timings.end(), [](const Timing& a, const Timing& b) {
    return a.draw_ms + a.shade_ms < b.draw_ms + b.shade_ms;
  });
  return timings[timings.size() / 2];
}

void draw(const Options& options, PictureMaker& maker, const Grid& grid, const Clouds& clouds,
          const Camera& camera, const std::string& name) {
  const auto in_view = clouds.in_view(camera, grid);
  const PictureOptions how{or_throw(colouring_of(options.colouring)), true};
  std::vector<Timing> timings;
  Picture picture;
  for (int i = 0; i < options.gl_repeat; ++i) {
    picture = or_throw(maker.make(camera, grid, in_view, how));
    timings.push_back({picture.draw_ms, picture.shade_ms});
  }
  const Timing typical = median(timings);
  const std::int64_t start = steady_utime();
  const Jpeg jpeg = or_throw(encode_jpeg(picture.image, 85, 150'000));
  fmt::print(
      "{0}_draw {1:.1f} ms\n{0}_shade {2:.1f} ms\n{0}_jpeg {3:.1f} ms\n{0}_quality {4} q\n"
      "{0}_cells {5} cells\n",
      name, typical.draw_ms, typical.shade_ms, static_cast<double>(steady_utime() - start) / 1000,
      jpeg.quality, picture.cells_drawn);
  if (options.out.empty()) return;
  bench::write_file(std::filesystem::path(options.out) / (name + ".png"),
                    or_throw(encode_png(picture.image)));
}

/// The GL backend, depth by depth, with its pictures.
void draw_all_depths(const Options& options, const Grid& grid, const Model& model,
                     const Camera& street, const Camera& oblique) {
  auto maker = or_throw(PictureMaker::create());
  for (int depth = kDepth; depth >= 0; --depth) {
    const Clouds clouds(model, depth);
    fmt::print("depth{0}_build {1:.1f} ms\ndepth{0}_memory {2} bytes\n", depth, clouds.build_ms(),
               clouds.bytes());
    draw(options, *maker, grid, clouds, street, fmt::format("depth{}_street", depth));
    draw(options, *maker, grid, clouds, oblique, fmt::format("depth{}_oblique", depth));
  }
}

/// Where to stand is sought in the tiles around the densest place alone: the rest need not be
/// drawn.
Camera find_street(const Grid& grid, const Model& model, const std::vector<TileWeight>& weights,
                   const ViewSize& size) {
  Model around;
  for (const TileKey key : street_tiles(grid, weights)) around.emplace(key, model.at(key));
  const Clouds clouds(around, kDepth);
  return or_throw(street_view(grid, weights, clouds.placed(street_tiles(grid, weights)), size));
}

void run(const Options& options) {
  const Grid grid = Grid::standard();
  const Model model = bench::make_model(options.source, grid);
  const auto weights = bench::weigh(model);
  const ViewSize size{options.width, options.height};
  const Camera street = find_street(grid, model, weights, size);
  bench::measure_splatter(model, grid, street, options.repeat, options.out);
  if (options.out.empty()) return;
  draw_all_depths(options, grid, model, street, or_throw(oblique_view(grid, weights, size)));
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Options options;
  CLI::App app{"times of pictures, depth by depth"};
  app.add_option("--data", options.source.data, "folder of scans in KITTI form; else simulated");
  app.add_option("--poses", options.source.poses, "its pose file");
  app.add_option("--scans", options.source.scans, "at most so many scans");
  app.add_option("--speed", options.source.speed, "of the simulated car, metres a second");
  app.add_option("--azimuth-step", options.source.azimuth_step_deg, "of its scanners, degrees");
  app.add_option("--cache", options.source.cache, "file that keeps the model for the next run");
  app.add_option("--repeat", options.repeat, "pictures a line")->check(CLI::Range(1, 1000));
  app.add_option("--gl-repeat", options.gl_repeat, "pictures a line of the GL backend by depth")
      ->check(CLI::Range(1, 1000));
  app.add_option("--width", options.width, "pixels")->check(CLI::Range(1, 8192));
  app.add_option("--height", options.height, "pixels")->check(CLI::Range(1, 8192));
  app.add_option("--colouring", options.colouring, "rgb, height, probability or depth");
  app.add_option("--out", options.out, "folder for PNGs, which must exist");
  CLI11_PARSE(app, argc, argv);
  try {
    voxatlas::run(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_render: {}\n", e.what());
    return 1;
  }
}
