// bench_codec: how small tiles become and how fast, beside OctoMap's files of the same tiles; and
// the paper's figures 7 and 8 again.
//
// Prints lines `name value unit`, for the simulated city and, with --data, for real scans; times
// are processor time of one thread. The tables are lines too: figure7_*, figure8_*.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>

#include "bench/codec_case.hpp"

namespace voxatlas::bench {
namespace {

struct Options {
  std::string data, poses = "poses.txt", only;
  std::size_t scans = 120, tiles = 1'000'000;
  bool json = false, tables = true;
};

struct Line {
  std::string name;
  double value;
  std::string unit;
};

using Lines = std::vector<Line>;

/// On standard error, as the whole takes minutes.
void progress(const std::string& model, const std::string& what) {
  fmt::print(stderr, "bench_codec: {}{}\n", model, what);
}

/// A row's name as part of a line's.
std::string slug(const std::string& name) {
  std::string result;
  for (const char letter : name) {
    if (std::isalnum(static_cast<unsigned char>(letter)) != 0) {
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    } else if (!result.empty() && result.back() != '_') {
      result += '_';
    }
  }
  while (!result.empty() && result.back() == '_') result.pop_back();
  return result;
}

void add_figures(const std::string& prefix, const CodecFigures& figures, double ot_zstd19,
                 Lines& lines) {
  const auto add = [&](const std::string& name, double value, const std::string& unit) {
    lines.push_back({prefix + name, value, unit});
  };
  const auto rate = [&](double seconds) { return figures.memory / seconds / 1e6; };
  add("lossless_vs_ot_zstd19", figures.dense / ot_zstd19, "fraction");
  add("lossless_reduction_vs_8B_node", 1 - figures.dense / (8 * figures.nodes), "fraction");
  add("lossy6_vs_lossless", figures.lossy6 / figures.dense, "fraction");
  add("dense_encode_MBps", rate(figures.dense_encode), "MB/s");
  add("dense_decode_MBps", rate(figures.dense_decode), "MB/s");
  add("fast_encode_MBps", rate(figures.fast_encode), "MB/s");
  add("fast_decode_MBps", rate(figures.fast_decode), "MB/s");
  add("bytes_per_occupied_cell", figures.dense / figures.occupied, "bytes");
  add("fast_bytes_per_occupied_cell", figures.fast / figures.occupied, "bytes");
  for (int depth = 0; depth <= 7; ++depth) {
    add(fmt::format("decode_to_depth_{}", depth), figures.to_depth[depth] / figures.dense_decode,
        "of the whole");
    add(fmt::format("bytes_to_depth_{}", depth), figures.cut[depth] / figures.dense,
        "of the whole");
  }
}

void add_figure_8(const std::string& prefix, const std::vector<Figure8Row>& rows, Lines& lines) {
  for (const auto& row : rows) {
    const std::string name = prefix + "figure8_" + slug(row.name);
    lines.push_back({name, row.bytes, "bytes"});
    lines.push_back({name + "_zstd3", row.zstd3, "bytes"});
    lines.push_back({name + "_zstd19", row.zstd19, "bytes"});
  }
}

void add_figure_7(const std::string& prefix, const std::vector<Figure7Row>& rows, Lines& lines) {
  for (const auto& row : rows) {
    const auto name = fmt::format("{}figure7_{}bits", prefix, row.bits);
    lines.push_back({name, row.clamps, "log-odds, levels between the clamps"});
    lines.push_back({name + "_unit", row.unit, "log-odds, bins of [0, 1]"});
  }
}

void add_model(const std::string& prefix, const CodecModel& model, bool tables, Lines& lines) {
  progress(prefix, fmt::format("codecs, {} tiles", model.tiles.size()));
  add_figures(prefix, measure_codecs(model), octomap_zstd19(model), lines);
  if (!tables) return;
  progress(prefix, "figure 8 (minutes)");
  add_figure_8(prefix, figure_8(model), lines);
  add_figure_8(prefix + "tile_", figure_8(representative(model)), lines);
  progress(prefix, "figure 7");
  add_figure_7(prefix, figure_7(model), lines);
}

/// What the uncoloured models must reach. A miss is said on standard error; the line stays as it
/// is.
void judge(const Lines& lines) {
  struct Target {
    const char* name;
    double least, most;
  };
  constexpr double kNone = 1e99;
  constexpr Target kTargets[] = {
      {"lossless_vs_ot_zstd19", 0, 0.60}, {"lossless_reduction_vs_8B_node", 0.95, kNone},
      {"lossy6_vs_lossless", 0, 0.80},    {"dense_encode_MBps", 20, kNone},
      {"dense_decode_MBps", 150, kNone},  {"fast_encode_MBps", 300, kNone},
      {"fast_decode_MBps", 1000, kNone},
  };
  for (const auto& line : lines) {
    for (const auto& target : kTargets) {
      if (line.name != fmt::format("sim_{}", target.name) &&
          line.name != fmt::format("real_{}", target.name)) {
        continue;
      }
      if (line.value >= target.least && line.value <= target.most) continue;
      fmt::print(stderr, "bench_codec: {} is {:.4g}, the target is {}\n", line.name, line.value,
                 target.most < kNone ? fmt::format("at most {}", target.most)
                                     : fmt::format("at least {}", target.least));
    }
  }
}

void print(const Lines& lines, bool json) {
  std::string text;
  for (const auto& line : lines) {
    text += json ? fmt::format("{}\"{}\": {:.6g}", text.empty() ? "{" : ", ", line.name, line.value)
                 : fmt::format("{} {:.6g} {}\n", line.name, line.value, line.unit);
  }
  fmt::print("{}{}", text, json ? "}\n" : "");
}

int serve(const Options& options) {
  using Make = std::function<Result<CodecModel>()>;
  std::vector<std::pair<std::string, Make>> models{
      {"sim", [&] { return simulated_model(options.scans, false); }},
      {"simcolour", [&] { return simulated_model(options.scans, true); }}};
  if (!options.data.empty()) {
    models.emplace_back("real",
                        [&] { return real_model(options.data, options.poses, options.scans); });
  }
  Lines lines;
  for (const auto& [name, make] : models) {
    if (!options.only.empty() && options.only != name) continue;
    progress(name, ": making the model");
    auto model = make();
    if (!model) {
      fmt::print(stderr, "bench_codec: {}\n", model.error().message);
      return 1;
    }
    model->tiles.resize(std::min(options.tiles, model->tiles.size()));
    add_model(name + "_", *model, options.tables, lines);
  }
  print(lines, options.json);
  judge(lines);
  return 0;
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::Options options;
  CLI::App app{"Tiles into bytes: ratios to OctoMap's files, speed, the paper's figures 7 and 8"};
  app.add_option("--data", options.data, "scans in KITTI odometry form, beside the simulated ones");
  app.add_option("--poses", options.poses, "the pose file, looked up in the folder first")
      ->capture_default_str();
  app.add_option("--scans", options.scans, "how many scans at most, of each kind")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  app.add_option("--tiles", options.tiles, "how many of its tiles at most, for a quick look")
      ->check(CLI::PositiveNumber);
  app.add_option("--only", options.only, "one of the models: sim, simcolour, real")
      ->check(CLI::IsMember({"sim", "simcolour", "real"}));
  app.add_flag("!--no-tables", options.tables, "leave figures 7 and 8 out");
  app.add_flag("--json", options.json, "one JSON object in place of lines");
  CLI11_PARSE(app, argc, argv);
  try {
    return voxatlas::bench::serve(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_codec: {}\n", e.what());
    return 1;
  }
}
