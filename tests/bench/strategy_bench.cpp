// The paper's section 4.1: its ray-based strategy, which is ours, against the tile-based one.
//
// Prints lines `name value unit`, for free space at 80 cm and at 10 cm. The tile-based strategy
// runs on one thread and on two, emptying its queues after every scan, and after all of them, as
// the paper seems to have done. Every measurement is a process of its own, so that memory is its
// own.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <functional>

#include "base/check.hpp"
#include "bench/import_scans.hpp"
#include "bench/strategy_case.hpp"

namespace voxatlas::bench {
namespace {

StrategyCost in_child(const std::function<StrategyCost()>& measure) {
  int ends[2];
  VOX_CHECK(pipe(ends) == 0);
  const pid_t child = fork();
  VOX_CHECK(child >= 0);
  if (child == 0) {
    const StrategyCost cost = measure();
    _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  close(ends[1]);
  StrategyCost cost;
  const auto got = read(ends[0], &cost, sizeof cost);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (got != sizeof cost || status != 0) throw std::runtime_error("a measurement crashed");
  return cost;
}

void print(const std::string& name, const StrategyCost& cost, double rays) {
  fmt::print("{0}_seconds {1:.6g} s\n{0}_rays_per_s {2:.6g} rays/s\n", name, cost.seconds,
             rays / cost.seconds);
  fmt::print("{0}_peak_bytes {1:.6g} bytes\n{0}_queue_bytes {2:.6g} bytes\n", name, cost.peak_bytes,
             cost.queue_bytes);
  fmt::print("{0}_tiles {1} tiles\n{0}_occupied {2} voxels\n", name, cost.tiles,
             cost.occupied_voxels);
}

void run(const std::vector<Scan>& scans) {
  double rays = 0;
  for (const auto& scan : scans) rays += static_cast<double>(scan.endpoints_ecef.size());
  fmt::print("scans {} scans\nrays {} rays\n", scans.size(), rays);
  const std::pair<const char*, int> cases[] = {{"free80", kBrickDepth}, {"free10", kDepth}};
  for (const auto& [name, depth] : cases) {
    const IntegrationParameters how{depth, kDepth, 0, 120, true};
    const auto measure = [&](const std::string& strategy, const auto& work) {
      print(std::string(name) + "_" + strategy, in_child(work), rays);
    };
    measure("ray", [&] { return ray_based(scans, how); });
    measure("tile_1t", [&] { return tile_based(scans, how, 1, 1); });
    measure("tile_2t", [&] { return tile_based(scans, how, 1, 2); });
    measure("tile_all_2t", [&] { return tile_based(scans, how, scans.size(), 2); });
  }
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  std::string data, poses = "poses.txt";
  std::size_t count = 20;
  CLI::App app{"The paper's two strategies of importing rays: time and memory"};
  app.add_option("--data", data, "scans in KITTI odometry form [the simulated drive]");
  app.add_option("--poses", poses, "the pose file, looked up in the folder first");
  app.add_option("--scans", count, "how many scans at most")->check(CLI::Range(1, 100'000));
  CLI11_PARSE(app, argc, argv);
  auto scans = data.empty() ? voxatlas::bench::simulated_scans(count)
                            : voxatlas::bench::real_scans(data, poses, count);
  if (!scans) {
    fmt::print(stderr, "bench_strategy: {}\n", scans.error().message);
    return 1;
  }
  try {
    voxatlas::bench::run(*scans);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_strategy: {}\n", e.what());
    return 1;
  }
}
