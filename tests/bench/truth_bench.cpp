// What the model knows against what is really there, for each way to treat free space.
//
// The scene was fixed before anything was tuned: the simulated city and drive as they are by
// default, 400 scans. Prints lines `rule_what value unit`; truth_case.hpp says what they mean.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "bench/render_model.hpp"
#include "bench/truth_case.hpp"
#include "sim/drive.hpp"

namespace voxatlas::bench {
namespace {

constexpr double kSigma = 0.02;

void print(const char* rule, const Quality& quality) {
  const auto line = [&](const char* what, double value, const char* unit) {
    fmt::print("{}_{} {:.6g} {}\n", rule, what, value, unit);
  };
  line("recall", quality.recall, "share");
  line("poles", quality.poles, "share");
  line("kept", quality.kept, "share");
  line("kept_poles", quality.kept_poles, "share");
  line("cleared_9", quality.cleared_9, "share");
  line("cleared_any", quality.cleared_any, "share");
  line("precision", quality.precision, "share");
  line("precision_then", quality.precision_then, "share");
  line("occupied", quality.occupied, "voxels");
  line("statics", quality.statics, "voxels");
  line("pole_voxels", quality.pole_voxels, "voxels");
  line("trail_9", quality.trail_9, "voxels");
  line("trail_any", quality.trail_any, "voxels");
}

void run(std::size_t scans, const std::string& only) {
  const City city = or_throw(City::create({}));
  DriveOptions how;
  how.scans = scans;
  const Drive drive = or_throw(Drive::create(city, how));
  how.sigma = 0;
  const Drive exact_drive = or_throw(Drive::create(city, how));
  Truth truth(city);
  std::vector<Rule> rules;
  for (std::size_t i = 0; i < Rule::kNames.size(); ++i) {
    const auto kind = static_cast<Rule::Kind>(i);
    if (only.empty() || only == Rule::kNames[i] || kind == Rule::Kind::kSurface) {
      rules.emplace_back(kind);
    }
  }
  for (std::size_t i = 0; i < scans; ++i) {
    truth.add(to_scan(exact_drive.simulate(i), kSigma, 0), drive.instant(i));
    const Scan noisy = to_scan(drive.simulate(i), kSigma, 0);
    for (Rule& rule : rules) rule.add(noisy);
  }
  fmt::print("scans {} scans\n", scans);
  for (const Rule& rule : rules) {
    print(rule.name(),
          compare(rule.tiles(), rules.back().tiles(), truth, city, drive.instant(scans - 1)));
  }
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  std::size_t scans = 400;
  std::string only;
  CLI::App app{"The model against the simulated truth, for each rule of free space"};
  app.add_option("--scans", scans, "of the drive")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  app.add_option("--only", only, "one rule beside surface: default, all_rays, pushed, carve");
  CLI11_PARSE(app, argc, argv);
  try {
    voxatlas::bench::run(scans, only);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_truth: {}\n", e.what());
    return 1;
  }
}
