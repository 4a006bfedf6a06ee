// voxatlas-tilestore: one shard of the model, durable.
//
//   in   VOXATLAS_CHUNK_STORE_s       chunk_t (scan_delta_t, tile_encoded_t)   reliable,
//                                     from ingest, compress
//   in   VOXATLAS_{MODEL,TILES,TILE,CHECKPOINT}_REQUEST   from anyone
//   out  VOXATLAS_{MODEL,TILES,TILE,CHECKPOINT}_REPLY     to who asked
//   out  VOXATLAS_TILE_UPDATE         tile_update_t         to anyone
//   out  VOXATLAS_CHUNK_COMPRESS_i    chunk_t (tile_raw_t)  reliable, to compress
//   out  VOXATLAS_ACK, VOXATLAS_STATUS
//
// What it has acknowledged survives a kill -9 and a power cut: journal first, then memory.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/log.hpp"
#include "bus/service_main.hpp"
#include "tilestore/tilestore_process.hpp"

namespace voxatlas {

static void declare(CLI::App& app, TilestoreOptions& options);
static void declare_model(CLI::App& app, ModelOptions& model);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::TilestoreOptions options;
  CLI::App app{"voxatlas tilestore: keeps one shard of the model", "voxatlas-tilestore"};
  voxatlas::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  return voxatlas::run_service(fmt::format("tilestore[{}]", options.shard),
                               voxatlas::Precedence::kStore,
                               [&] { return voxatlas::serve_tilestore(options); });
}

namespace voxatlas {

static void declare(CLI::App& app, TilestoreOptions& options) {
  app.add_option("--url", options.url, "LCM URL of the bus")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  app.add_option("--data-dir,--store", options.data_dir,
                 "folder of the model; made where it is not there. Or rados:CONF,POOL[,MODEL]: a "
                 "model in the Ceph cluster of that ceph.conf")
      ->required();
  app.add_option("--shard", options.shard, "which shard this process owns")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--shards", options.shards, "how many shards the model has")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--compressors", options.compressors, "how many compress services there may be")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_option_function<std::size_t>(
         "--cache-mb", [&options](std::size_t mb) { options.memory_bytes = mb << 20; },
         "memory for tiles and all that goes with them, MiB, at least 64; the process stays "
         "within 1.5 times this [256]")
      ->check(CLI::Range(1, 1 << 20));
  app.add_option_function<std::size_t>(
         "--journal-mb", [&options](std::size_t mb) { options.journal_max_bytes = mb << 20; },
         "most the journal may hold, MiB [32]")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option("--rest-seconds", options.rest_seconds,
                 "a tile unchanged for so long is given to a compressor")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  app.add_option("--rest-bytes", options.rest_bytes, "if it is stored in at least so many bytes")
      ->check(CLI::Range(0, 1 << 30))
      ->capture_default_str();
  app.add_flag("--keep-journal", options.keep_journal,
               "never trim the journal: what the model is made of can be replayed, on more disk");
  declare_model(app, options.model);
  app.add_flag_callback("--log-json", log_as_json, "log each event as one JSON object");
  app.set_config("--config", "", "read options from a TOML file");
  app.allow_config_extras(CLI::config_extras_mode::error);  // A misspelt key must not pass.
}

static void declare_model(CLI::App& app, ModelOptions& model) {
  const char* group = "Model (fixed when it is made; one that differs from the stored is refused)";
  app.add_option("--cells-per-metre", model.cells_per_metre, "resolution, 1 to 20 [10]")
      ->group(group);
  app.add_option("--free-depth", model.free_depth,
                 "depth of free space: 0 to 7 (10 cm), -1 for none [4: 80 cm]")
      ->group(group);
  app.add_option("--all-rays-free", model.all_rays_free,
                 "true: each ray frees all it passes; false: some do where free space is coarser "
                 "than the surface, one in 80 at 80 cm [false]")
      ->group(group);
  app.add_option("--surface-depth", model.surface_depth, "deepest surface, 0 to 7 [7]")
      ->group(group);
  app.add_option("--min-range", model.min_range, "nearer returns are dropped, metres [0]")
      ->group(group);
  app.add_option("--max-range", model.max_range, "farther returns only free, metres [120]")
      ->group(group);
  app.add_option("--hit", model.hit, "probability a hit stands for [0.7]")->group(group);
  app.add_option("--miss", model.miss, "probability a miss stands for [0.4]")->group(group);
  app.add_option("--clamp-min", model.clamp_min, "lowest probability of a cell [0.12]")
      ->group(group);
  app.add_option("--clamp-max", model.clamp_max, "highest probability of a cell [0.97]")
      ->group(group);
}

}  // namespace voxatlas
