// What the tile store costs over the engine below it, and how long it takes to come back.
//
//   bench_store [--dir DIR] [--data DIR --poses FILE] [--json] [--only NAME]
//
// tile_commit_vs_raw       tiles written, 32 a put, over raw RocksDB's rate with the same rows
// journal_commit16_vs_raw  1.5 kB records by 16 threads at once on one shard, likewise
// space_after_8x           bytes on disk over live bytes, after each tile was written 8 times
// open_after_kill_s        a shard opened after kill -9 with a full journal, seconds; with --data
//                          also real_open_after_kill_s, of those scans in place of simulated ones
//
// Ours and raw take turns in short slices, so that both see the same disk; a ratio is the median
// over the slices. Lines are "name value unit"; the targets stand in the third column's words.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "bench/store_case.hpp"

namespace voxatlas::bench {
namespace {

struct Options {
  std::string dir, data, poses = "poses.txt", only;
  bool json = false;
};

struct Line {
  std::string name;
  double value;
  std::string unit;
};

void print(const std::vector<Line>& lines, bool json) {
  std::string text;
  for (const auto& line : lines) {
    if (json) {
      text += fmt::format("{}\"{}\": {:.4g}", text.empty() ? "" : ", ", line.name, line.value);
    } else {
      fmt::print("{} {:.4g} {}\n", line.name, line.value, line.unit);
    }
  }
  if (json) fmt::print("{{{}}}\n", text);
}

/// A target that was missed is said so, on standard error: the figures stay what they are.
void judge(const Line& line, bool met, const std::string& target) {
  if (!met) {
    fmt::print(stderr, "bench_store: {} is {:.3g}, the target is {}\n", line.name, line.value,
               target);
  }
}

void add(std::vector<Line>& lines, Line line, bool met, const std::string& target) {
  judge(line, met, target);
  lines.push_back(std::move(line));
}

void compare(std::vector<Line>& lines, const std::string& name, const Comparison& found) {
  add(lines, {name, found.ratio, "of_raw"}, found.ratio >= 0.8, "0.8 or more");
  lines.push_back({name + "_ours", found.ours_per_s, "1/s"});
  lines.push_back({name + "_raw", found.raw_per_s, "1/s"});
}

void opened(std::vector<Line>& lines, const std::string& prefix, const Opening& opening) {
  add(lines, {prefix + "open_after_kill_s", opening.seconds, "s"}, opening.seconds < 3, "below 3");
  lines.push_back({prefix + "open_after_kill_journal", opening.journal_mib, "MiB"});
  lines.push_back({prefix + "open_after_kill_records", opening.records, "records"});
  lines.push_back({prefix + "open_after_kill_tiles", opening.tiles, "tiles"});
}

void run(const Options& options) {
  const auto wanted = [&](const char* name) {
    return options.only.empty() || options.only == name;
  };
  std::vector<Line> lines;
  if (wanted("open_after_kill_s")) {
    const bool real = !options.data.empty();
    simulate_and_kill(options.dir + "/killed");
    if (real) drive_and_kill(options.dir + "/killed-real", options.data, options.poses);
    opened(lines, "", open_after_kill(options.dir + "/killed"));
    if (real) opened(lines, "real_", open_after_kill(options.dir + "/killed-real"));
  }
  if (wanted("tile_commit_vs_raw")) {
    compare(lines, "tile_commit_vs_raw", compare_tile_commits(options.dir + "/tiles"));
  }
  if (wanted("journal_commit16_vs_raw")) {
    compare(lines, "journal_commit16_vs_raw", compare_journal_commits(options.dir + "/journal"));
  }
  if (wanted("space_after_8x")) {
    const double space = space_after_overwriting(options.dir + "/space");
    add(lines, {"space_after_8x", space, "of_live_bytes"}, space <= 1.6, "1.6 or less");
  }
  print(lines, options.json);
}

/// A folder of its own below the one given, gone at the end.
class Folder {
 public:
  explicit Folder(const std::string& parent) {
    path_ = (std::filesystem::path(parent) / "voxatlas_bench_XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) throw std::runtime_error("cannot make " + path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::Options options;
  options.dir = std::filesystem::temp_directory_path().string();
  CLI::App app{"the tile store against raw RocksDB, its space and its recovery"};
  app.add_option("--dir", options.dir, "on which disk; about 3 GB are used for a while");
  app.add_option("--data", options.data, "scans in KITTI odometry form, for open_after_kill_s");
  app.add_option("--poses", options.poses, "the pose file, looked up in the folder first")
      ->capture_default_str();
  app.add_option("--only", options.only, "one of the four lines");
  app.add_flag("--json", options.json, "print as one JSON object");
  CLI11_PARSE(app, argc, argv);
  try {
    const voxatlas::bench::Folder folder(options.dir);
    options.dir = folder.path();
    voxatlas::bench::run(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_store: {}\n", e.what());
    return 1;
  }
}
