// bench_import: how fast scans become tiles, beside OctoMap on the same scans in the same run.
//
// Prints lines `name value unit`. Every measurement is a process of its own, so that memory is what
// one map takes; times are processor time of one thread, but for threads2_speedup.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstring>
#include <functional>

#include "base/check.hpp"
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

constexpr double kSlowestOctomap = 15'000;  ///< Rays/s; below, the machine was not ours.

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

struct Pair {
  ImportTiming ours, octomap;
};

/// Both on the scans that OctoMap manages in its time.
Pair measure(const std::vector<Scan>& scans, const IntegrationParameters& how,
             double octomap_seconds) {
  Pair pair;
  pair.octomap = in_child([&] { return import_octomap(scans, how, octomap_seconds); });
  const auto count = static_cast<std::ptrdiff_t>(pair.octomap.scans);
  const std::vector<Scan> same(scans.begin(), scans.begin() + count);
  pair.ours = in_child([&] { return import_ours(same, how); });
  return pair;
}

void add_warm(std::vector<Line>& lines, const std::string& name, const std::string& phase,
              const Pair& pair) {
  const double ours = pair.ours.warm_rays / pair.ours.warm_cpu;
  const double theirs = pair.octomap.warm_rays / pair.octomap.warm_cpu;
  lines.push_back({name + phase + "_vs_octomap", ours / theirs, "x"});
  lines.push_back({name + phase + "_rays_per_s", ours, "rays/s"});
}

void add_cold(std::vector<Line>& lines, const std::string& name, const Pair& pair) {
  const double ours = pair.ours.cold_rays / pair.ours.cold_cpu;
  const double theirs = pair.octomap.cold_rays / pair.octomap.cold_cpu;
  lines.push_back({name + "_cold_vs_octomap", ours / theirs, "x"});
  lines.push_back({name + "_cold_rays_per_s", ours, "rays/s"});
}

std::vector<Line> run(const std::vector<Scan>& scans, const Options& options) {
  const IntegrationParameters carve100{kDepth, kDepth, 0, 100}, carve30{kDepth, kDepth, 0, 30};
  const IntegrationParameters surface{IntegrationParameters::kNoFreeSpace, kDepth, 0, 100};
  const IntegrationParameters free80{kBrickDepth, kDepth, 0, 100};
  const double seconds = options.octomap_seconds;
  std::vector<Line> lines;

  const auto carve = measure(scans, carve100, seconds);
  add_warm(lines, "carve100", "_warm", carve);
  add_cold(lines, "carve100", carve);
  add_warm(lines, "carve30", "_warm", measure(scans, carve30, seconds));
  add_warm(lines, "surface", "", measure(scans, surface, seconds));
  add_warm(lines, "free80", "", measure(scans, free80, seconds));
  lines.push_back({"threads2_speedup", two_threads_speedup(scans, carve100), "x"});
  lines.push_back(
      {"memory_vs_octomap", carve.ours.resident_bytes / carve.octomap.resident_bytes, "fraction"});
  lines.push_back({"delta_bytes_per_ray", carve.ours.delta_bytes / carve.ours.rays(), "bytes"});
  const double octomap_rate = carve.octomap.rays() / carve.octomap.cpu();
  lines.push_back({"octomap_carve100_rays_per_s", octomap_rate, "rays/s"});
  lines.push_back({"octomap_carve100_scans", carve.octomap.scans, "scans"});
  if (octomap_rate < kSlowestOctomap) {
    fmt::print(stderr,
               "bench_import: OctoMap carved {:.0f} rays/s, less than {:.0f}: the ratios "
               "are void, something else uses this machine\n",
               octomap_rate, kSlowestOctomap);
  }
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
