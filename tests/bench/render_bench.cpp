// How long pictures take, depth by depth, and the pictures themselves.
//
//   bench_render [--data DIR --poses FILE] [--scans N] [--out DIR]
//
// Integrates scans, in KITTI form or of the simulated drive, and draws the street view and the
// oblique view at depths 0..7: the median of several pictures a line, as "name value unit". With
// --out also PNGs to look at.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

#include "base/utime.hpp"
#include "integrate/integrator.hpp"
#include "io/kitti.hpp"
#include "octree/tile_tree.hpp"
#include "render/frustum.hpp"
#include "render/picture.hpp"
#include "render/viewpoints.hpp"
#include "sim/drive.hpp"

namespace voxatlas {
namespace {

struct Options {
  std::string data, poses = "poses.txt", out, colouring = "rgb";
  std::size_t scans = 200;
  int repeat = 5;
  int width = 1280, height = 720;
};

using Model = std::map<TileKey, TileTree>;

struct Timing {
  double draw_ms, shade_ms;
};

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

using EachScan = std::function<void(const SensorScan&)>;

void read_scans(const Options& options, const EachScan& each) {
  const auto folder = or_throw(KittiFolder::open(options.data, {options.poses, std::nullopt}));
  for (std::size_t i = 0; i < std::min(options.scans, folder.scan_count()); ++i) {
    each(or_throw(folder.read(i)).scan);
  }
}

void simulate_scans(const Options& options, const EachScan& each) {
  const City city = or_throw(City::create({}));
  DriveOptions how;
  how.scans = options.scans;
  const Drive drive = or_throw(Drive::create(city, how));
  for (std::size_t i = 0; i < drive.scan_count(); ++i) each(drive.simulate(i));
}

Model integrate(const Options& options, const Grid& grid) {
  Integrator integrator(grid, IntegrationParameters{});
  Model model;
  const auto each = [&](const SensorScan& scan) {
    const auto delta = or_throw(integrator.integrate(to_scan(scan, 0.02, 2.5)));
    for (const auto& [key, tile] : delta.tiles) model[key].apply(tile, SensorModel::standard());
  };
  options.data.empty() ? simulate_scans(options, each) : read_scans(options, each);
  return model;
}

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

std::vector<TileWeight> weigh(const Model& model) {
  std::vector<TileWeight> weights;
  for (const auto& [key, tree] : model) weights.push_back({key, tree.counts().occupied_voxels});
  return weights;
}

void write(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out) throw std::runtime_error("cannot write " + path.string());
}

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
  for (int i = 0; i < options.repeat; ++i) {
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
  write(std::filesystem::path(options.out) / (name + ".png"), or_throw(encode_png(picture.image)));
}

void run(const Options& options) {
  const Grid grid = Grid::standard();
  const Model model = integrate(options, grid);
  const auto weights = weigh(model);
  const ViewSize size{options.width, options.height};
  const Clouds finest(model, kDepth);
  const Camera street =
      or_throw(street_view(grid, weights, finest.placed(street_tiles(grid, weights)), size));
  const Camera oblique = or_throw(oblique_view(grid, weights, size));
  auto maker = or_throw(PictureMaker::create());
  for (int depth = kDepth; depth >= 0; --depth) {
    const Clouds clouds(model, depth);
    fmt::print("depth{0}_build {1:.1f} ms\ndepth{0}_memory {2} bytes\n", depth, clouds.build_ms(),
               clouds.bytes());
    draw(options, *maker, grid, clouds, street, fmt::format("depth{}_street", depth));
    draw(options, *maker, grid, clouds, oblique, fmt::format("depth{}_oblique", depth));
  }
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Options options;
  CLI::App app{"times of pictures, depth by depth"};
  app.add_option("--data", options.data, "folder of scans in KITTI form; else simulated");
  app.add_option("--poses", options.poses, "its pose file");
  app.add_option("--scans", options.scans, "at most so many scans");
  app.add_option("--repeat", options.repeat, "pictures a line")->check(CLI::Range(1, 1000));
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
