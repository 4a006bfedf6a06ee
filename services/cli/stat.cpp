#include "cli/stat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <vector>

#include "cli/json_text.hpp"
#include "cli/model_client.hpp"
#include "cli/progress.hpp"

namespace voxatlas {

namespace {

struct Sums {
  std::int64_t tiles = 0, encoded_bytes = 0, leaves = 0;
  std::int64_t occupied_leaves = 0, free_leaves = 0, occupied_voxels = 0, free_voxels = 0;

  void add(const ModelClient::TileRow& row) {
    ++tiles;
    encoded_bytes += row.encoded_bytes;
    leaves += row.leaves;
    occupied_leaves += row.occupied_leaves;
    free_leaves += row.free_leaves;
    occupied_voxels += row.occupied_voxels;
    free_voxels += row.free_voxels;
  }
};

Status write_hashes(const std::string& path, std::vector<ModelClient::TileRow>& rows) {
  // By key, whatever shard a tile lies in: models with different shards can be compared.
  std::ranges::sort(rows, {}, &ModelClient::TileRow::key);
  std::ofstream out(path);
  for (const auto& row : rows) {
    out << fmt::format("{:016x} {} {}\n", row.key, row.version, row.hash);
  }
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path));
  return {};
}

JsonObject describe(const ModelParameters& parameters) {
  JsonObject json;
  json.add("cells_per_metre", std::int64_t{parameters.cells_per_metre})
      .add("shards", std::int64_t{parameters.shards})
      .add("free_depth", std::int64_t{parameters.integration.free_depth})
      .add("all_rays_free", std::int64_t{parameters.integration.all_rays_free})
      .add("surface_depth", std::int64_t{parameters.integration.surface_depth})
      .add("min_range", parameters.integration.min_range)
      .add("max_range", parameters.integration.max_range)
      .add("hit", to_probability(parameters.sensor.hit))
      .add("miss", to_probability(parameters.sensor.miss))
      .add("clamp_min", to_probability(parameters.sensor.clamp_min))
      .add("clamp_max", to_probability(parameters.sensor.clamp_max));
  return json;
}

void print_json(const Sums& sums, const ModelClient& client) {
  JsonObject json;
  json.add("tiles", sums.tiles)
      .add("leaves", sums.leaves)
      .add("occupied_leaves", sums.occupied_leaves)
      .add("free_leaves", sums.free_leaves)
      .add("occupied_voxels", sums.occupied_voxels)
      .add("free_voxels", sums.free_voxels)
      .add("encoded_bytes", sums.encoded_bytes)
      .add("disk_bytes", client.disk_bytes())
      .add("parameters", describe(client.parameters()));
  fmt::print("{}\n", json.text());
}

void print_table(const Sums& sums, const ModelClient& client) {
  const auto& parameters = client.parameters();
  const auto line = [](const char* name, auto value, const char* unit) {
    fmt::print("{:<22}{:>16} {}\n", name, value, unit);
  };
  line("tiles", sums.tiles, "");
  line("leaves", sums.leaves, "");
  line("  occupied", sums.occupied_leaves, "");
  line("  free", sums.free_leaves, "");
  line("voxels occupied", sums.occupied_voxels, "");
  line("voxels free", sums.free_voxels, "");
  line("encoded tiles", sums.encoded_bytes, "bytes");
  line("on disk", client.disk_bytes(), "bytes");
  line("shards", parameters.shards, "");
  line("cell", fmt::format("{:.3g}", 1.0 / parameters.cells_per_metre), "m");
  line("free space at depth", parameters.integration.free_depth, "(-1: none)");
  line("rays that free", parameters.integration.all_rays_free ? "all" : "by width", "");
  line("longest ray", parameters.integration.max_range, "m");
}

}  // namespace

Status run_stat(const StatOptions& options) {
  auto client = ModelClient::connect(options.url);
  if (!client) return pass_on(client);
  Sums sums;
  std::vector<ModelClient::TileRow> rows;
  Progress progress;
  auto listed = (*client)->for_each_tile(true, [&](const ModelClient::TileRow& row) {
    sums.add(row);
    if (!options.hashes.empty()) rows.push_back(row);
    progress.say(fmt::format("{} tiles", sums.tiles));
  });
  if (!listed) return listed;
  if (!options.hashes.empty()) {
    if (auto written = write_hashes(options.hashes, rows); !written) return written;
  }
  options.json ? print_json(sums, **client) : print_table(sums, **client);
  return {};
}

}  // namespace voxatlas
