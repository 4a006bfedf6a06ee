// bench_octomap: how fast OctoMap alone integrates the first scans, in one process, with neither
// bus nor disk. What `bench endtoend` divides by; times are wall time, as there.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "bench/huge_pages.hpp"
#include "bench/import_case.hpp"
#include "bench/import_scans.hpp"

namespace voxatlas::bench {
namespace {

struct Options {
  std::string data, poses = "poses.txt";
  std::size_t scans = 5;
  double max_range = 120;
};

int serve(const Options& options) {
  auto scans = options.data.empty() ? simulated_scans(options.scans)
                                    : real_scans(options.data, options.poses, options.scans);
  if (!scans) {
    fmt::print(stderr, "bench_octomap: {}\n", scans.error().message);
    return 1;
  }
  constexpr double kAllOfThem = 1e9;
  const double start = wall_seconds();
  const auto timing = import_octomap(*scans, {kDepth, kDepth, 0, options.max_range}, kAllOfThem);
  const double seconds = wall_seconds() - start;
  fmt::print("octomap_carve10_rays_per_s {:.0f} rays/s\n", timing.rays() / seconds);
  fmt::print("octomap_carve10_cpu_rays_per_s {:.0f} rays/s\n", timing.rays() / timing.cpu());
  return 0;
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::put_heap_on_huge_pages(argv);
  voxatlas::bench::Options options;
  CLI::App app{"OctoMap carving at 10 cm, rays a second"};
  app.add_option("--data", options.data, "scans in KITTI odometry form [the simulated drive]");
  app.add_option("--poses", options.poses, "the pose file, looked up in the folder first")
      ->capture_default_str();
  app.add_option("--scans", options.scans, "how many scans")->capture_default_str();
  app.add_option("--max-range", options.max_range, "metres")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return voxatlas::bench::serve(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_octomap: {}\n", e.what());
    return 1;
  }
}
