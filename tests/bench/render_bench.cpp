// How long pictures take, and the pictures themselves.
//
//   bench_render [--data DIR --poses FILE] [--scans N] [--cache FILE] [--out DIR]
//
// Draws a street view, one from 20 m above it and one from 60 m, of what lies within 100 m: of the
// simulated city (11.4 M occupied cells; --scans 1600 --speed 40 scans more streets more thinly,
// 22.4 M), or with --data of scans in KITTI form. Lines "name value unit": the median of 20
// pictures each, beside the paper's table 1 and the GL backend in the same run; `occupied_cells`
// says what the model has, `_cells_in_view` what a view has; `far500_` lines are of the same views
// of all within 500 m. With --out also PNGs to look at.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>

#include "bench/render_model.hpp"
#include "bench/render_pictures.hpp"
#include "bench/render_splat.hpp"
#include "geodesy/ecef.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas {
namespace {

using bench::Model;
using bench::or_throw;
using bench::View;

constexpr double kField = 100, kFarField = 500;  // Metres.

struct Options {
  bench::ModelSource source;
  bench::PictureFiles pictures;
  int repeat = 20;
  int width = 1280, height = 720;
  bool far_field = true;
};

/// Where to stand is sought in the tiles around the densest place alone.
Camera find_street(const Grid& grid, const Model& model, const ViewSize& size) {
  const auto weights = bench::weigh(model);
  const auto keys = street_tiles(grid, weights);
  std::vector<CellCloud> clouds;
  clouds.reserve(keys.size());  // They must not move.
  std::vector<PlacedCloud> placed;
  for (const TileKey key : keys) {
    placed.push_back({key, &clouds.emplace_back(model.at(key), kDepth)});
  }
  return or_throw(street_view(grid, weights, placed, size));
}

/// The street view, raised and turned down, up to a range.
Camera seen_from(const Camera& street, double metres, double down_deg, double far_range) {
  const Eigen::Vector3d up = up_at(street.position());
  const Eigen::Vector3d ahead = street.orientation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d level = (ahead - ahead.dot(up) * up).normalized();
  const double angle = down_deg * std::numbers::pi / 180;
  const Eigen::Vector3d eye = street.position() + metres * up;
  Lens lens = street.lens();
  lens.far_range = far_range;
  return or_throw(
      Camera::look_at(eye, eye + std::cos(angle) * level - std::sin(angle) * up, up, lens));
}

std::vector<View> views_of(const Camera& street, double far_range, const std::string& prefix) {
  return {{prefix + "street", seen_from(street, 0, 0, far_range)},
          {prefix + "oblique", seen_from(street, 20, 20, far_range)},
          {prefix + "aerial", seen_from(street, 60, 55, far_range)}};
}

void run(Options options) {
  const Grid grid = Grid::standard();
  options.source.surfaces_only = options.source.data.empty() && options.pictures.folder.empty();
  const Model model = bench::make_model(options.source, grid);
  const Camera street = find_street(grid, model, {options.width, options.height});
  bench::SplatBench bench(model, grid, options.repeat);
  bench.print_memory();
  bench.print_coarse_build();
  const auto views = views_of(street, kField, "");
  for (const View& view : views) bench.print_view(view);
  bench.print_gains(views.front());
  bench.print_depths(views.front());
  bench.print_against_gl(views);
  const auto far_views = views_of(street, kFarField, "far500_");
  if (options.far_field) {
    for (const View& view : far_views) bench.print_view(view);
    bench.print_against_gl(far_views);
  }
  if (options.pictures.folder.empty()) return;
  bench::write_pictures(model, grid, bench.placed(), views_of(street, kFarField, ""),
                        options.pictures);
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Options options;
  CLI::App app{"times of pictures, and pictures"};
  app.add_option("--data", options.source.data, "folder of scans in KITTI form; else simulated");
  app.add_option("--poses", options.source.poses, "its pose file");
  app.add_option("--scans", options.source.scans, "at most so many scans")->capture_default_str();
  app.add_option("--speed", options.source.speed, "of the simulated car, metres a second")
      ->capture_default_str();
  app.add_option("--azimuth-step", options.source.azimuth_step_deg, "of its scanners, degrees")
      ->capture_default_str();
  app.add_option("--cache", options.source.cache, "file that keeps the model for the next run");
  app.add_option("--repeat", options.repeat, "pictures a line")->check(CLI::Range(1, 1000));
  app.add_option("--width", options.width, "pixels")->check(CLI::Range(1, 8192));
  app.add_option("--height", options.height, "pixels")->check(CLI::Range(1, 8192));
  app.add_flag("!--no-far-field", options.far_field, "nothing of what lies within 500 m");
  app.add_option("--out", options.pictures.folder, "folder for PNGs, which must exist");
  app.add_option("--jpeg", options.pictures.jpeg_quality, "JPEGs of this quality instead")
      ->check(CLI::Range(1, 100));
  CLI11_PARSE(app, argc, argv);
  try {
    voxatlas::run(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_render: {}\n", e.what());
    return 1;
  }
}
