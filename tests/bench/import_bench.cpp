// bench_import: how fast scans become tiles, beside OctoMap on the same scans in the same run.
//
// Prints lines `name value unit`. Every measurement is a process of its own, so that memory is what
// one map takes, on huge pages; times are processor time of one thread, but for threads2_speedup.
// "cold" is the first quarter of the scans, into an empty map; "warm", or nothing said, the others.
// Ours is the median of five runs, "noise" how far the fastest and the slowest lay apart. Where
// OctoMap carves less than 15 000 rays/s, which is slower than the machine this limit is of, a
// ratio's unit is x_void.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "base/check.hpp"
#include "bench/huge_pages.hpp"
#include "bench/import_case.hpp"
#include "bench/import_scans.hpp"

namespace voxatlas::bench {
namespace {

struct Options {
  std::string data, poses = "poses.txt";
  std::size_t scans = 20;
  double octomap_seconds = 30;
  bool json = false;
};

struct Line {
  std::string name;
  double value;
  std::string unit;
};

constexpr double kSlowestOctomap = 15'000;  ///< Carving, rays/s; below, ratios say nothing.

/// Runs `measure` in a child process and hands over what it returns.
ImportTiming in_child(const std::function<ImportTiming()>& measure) {
  int ends[2];
  VOX_CHECK(pipe(ends) == 0);
  const pid_t child = fork();
  VOX_CHECK(child >= 0);
  if (child == 0) {
    const ImportTiming timing = measure();
    _exit(write(ends[1], &timing, sizeof timing) == sizeof timing ? 0 : 1);
  }
  close(ends[1]);
  ImportTiming timing;
  const auto got = read(ends[0], &timing, sizeof timing);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (got != sizeof timing || status != 0) throw std::runtime_error("a measurement crashed");
  return timing;
}

/// One case, both on the scans that OctoMap manages in its time; ours several times, as it is
/// short.
struct Pair {
  static constexpr std::size_t kRuns = 5;
  std::array<ImportTiming, kRuns> runs;  ///< Ascending by time.
  ImportTiming octomap;

  const ImportTiming& ours() const { return runs[kRuns / 2]; }
  double warm() const { return ours().warm_rays / ours().warm_cpu; }
  double cold() const { return ours().cold_rays / ours().cold_cpu; }
  double noise() const { return (runs.back().cpu() - runs.front().cpu()) / ours().cpu(); }
};

Pair measure(const std::vector<Scan>& scans, const IntegrationParameters& how,
             double octomap_seconds) {
  Pair pair;
  pair.octomap = in_child([&] { return import_octomap(scans, how, octomap_seconds); });
  const auto count = static_cast<std::ptrdiff_t>(pair.octomap.scans);
  const std::vector<Scan> same(scans.begin(), scans.begin() + count);
  for (auto& run : pair.runs) run = in_child([&] { return import_ours(same, how); });
  std::sort(pair.runs.begin(), pair.runs.end(),
            [](const auto& a, const auto& b) { return a.cpu() < b.cpu(); });
  return pair;
}

/// The lines of one case; a ratio's unit says where it is void.
void add_case(std::vector<Line>& lines, const std::string& name, const std::string& warm,
              const Pair& pair, bool valid) {
  const std::string unit = valid ? "x" : "x_void";
  const auto& octomap = pair.octomap;
  lines.push_back(
      {name + warm + "_vs_octomap", pair.warm() * octomap.warm_cpu / octomap.warm_rays, unit});
  lines.push_back(
      {name + "_cold_vs_octomap", pair.cold() * octomap.cold_cpu / octomap.cold_rays, unit});
  lines.push_back({name + warm + "_rays_per_s", pair.warm(), "rays/s"});
  lines.push_back({name + "_cold_rays_per_s", pair.cold(), "rays/s"});
  lines.push_back({name + "_noise", pair.noise(), "fraction"});
  lines.push_back({"octomap_" + name + "_rays_per_s", octomap.rays() / octomap.cpu(), "rays/s"});
}

std::vector<Line> run(const std::vector<Scan>& scans, const Options& options) {
  const IntegrationParameters carve100{kDepth, kDepth, 0, 100}, carve30{kDepth, kDepth, 0, 30};
  const IntegrationParameters surface{IntegrationParameters::kNoFreeSpace, kDepth, 0, 100};
  const IntegrationParameters free80{kBrickDepth, kDepth, 0, 100, true};
  const double seconds = options.octomap_seconds;
  std::vector<Line> lines;

  const auto carve = measure(scans, carve100, seconds);
  const double octomap_rate = carve.octomap.rays() / carve.octomap.cpu();
  const bool valid = octomap_rate >= kSlowestOctomap;
  if (!valid) {
    fmt::print(stderr,
               "bench_import: OctoMap carved {:.0f} rays/s, less than {:.0f}: the ratios are void, "
               "the machine is too slow or something else uses it\n",
               octomap_rate, kSlowestOctomap);
  }
  add_case(lines, "carve100", "_warm", carve, valid);
  add_case(lines, "carve30", "_warm", measure(scans, carve30, seconds), valid);
  add_case(lines, "surface", "", measure(scans, surface, seconds), valid);
  add_case(lines, "free80", "", measure(scans, free80, seconds), valid);
  lines.push_back({"threads2_speedup", two_threads_speedup(scans, carve100), "x"});
  lines.push_back({"memory_vs_octomap", carve.ours().resident_bytes / carve.octomap.resident_bytes,
                   "fraction"});
  lines.push_back({"delta_bytes_per_ray", carve.ours().delta_bytes / carve.ours().rays(), "bytes"});
  lines.push_back({"ratios_void", valid ? 0.0 : 1.0, "flag"});
  lines.push_back({"octomap_carve100_scans", carve.octomap.scans, "scans"});
  return lines;
}

void print(const std::vector<Line>& lines, bool json) {
  std::string text;
  for (const auto& line : lines) {
    text += json ? fmt::format("{}\"{}\": {:.6g}", text.empty() ? "{" : ", ", line.name, line.value)
                 : fmt::format("{} {:.6g} {}\n", line.name, line.value, line.unit);
  }
  fmt::print("{}{}", text, json ? "}\n" : "");
}

int serve(const Options& options) {
  auto scans = options.data.empty() ? simulated_scans(options.scans)
                                    : real_scans(options.data, options.poses, options.scans);
  if (!scans) {
    fmt::print(stderr, "bench_import: {}\n", scans.error().message);
    return 1;
  }
  print(run(*scans, options), options.json);
  return 0;
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::put_heap_on_huge_pages(argv);
  voxatlas::bench::Options options;
  CLI::App app{"Scans into tiles: rays a second, and ratios to OctoMap on the same scans"};
  app.add_option("--data", options.data, "scans in KITTI odometry form [the simulated drive]");
  app.add_option("--poses", options.poses, "the pose file, looked up in the folder first")
      ->capture_default_str();
  app.add_option("--scans", options.scans, "how many scans at most")
      ->capture_default_str()
      ->check(CLI::Range(4, 100'000));
  app.add_option("--octomap-seconds", options.octomap_seconds, "time OctoMap has for each case")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3600.0));
  app.add_flag("--json", options.json, "one JSON object in place of lines");
  CLI11_PARSE(app, argc, argv);
  try {
    return voxatlas::bench::serve(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_import: {}\n", e.what());
    return 1;
  }
}
