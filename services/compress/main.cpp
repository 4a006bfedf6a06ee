// voxatlas-compress: rested tiles in, densely encoded tiles out.
//
//   in   VOXATLAS_CHUNK_COMPRESS_i  chunk_t (tile_raw_t)      reliable, from tilestores
//   out  VOXATLAS_CHUNK_STORE_s     chunk_t (tile_encoded_t)  reliable, to the tile's tilestore
//   out  VOXATLAS_ACK, VOXATLAS_STATUS
//
// It keeps no state: start as many as there are cores, kill them at will; a tile whose result the
// store does not have comes again, and the store drops what has become stale.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/log.hpp"
#include "bus/service_main.hpp"
#include "compress/compress_process.hpp"
#include "compress/compress_service.hpp"

namespace voxatlas {

static void declare(CLI::App& app, CompressOptions& options);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::CompressOptions options;
  CLI::App app{"voxatlas compress: encodes tiles that rest densely", "voxatlas-compress"};
  voxatlas::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  return voxatlas::run_service(fmt::format("compress[{}]", options.index),
                               voxatlas::Precedence::kCompress,
                               [&] { return voxatlas::serve_compress(options); });
}

namespace voxatlas {

static void declare(CLI::App& app, CompressOptions& options) {
  app.add_option("--url", options.url, "LCM URL of the bus")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  app.add_option("--index", options.index, "number of this compressor")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--stores", options.stores, "how many tilestores (shards) the model has")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option_function<std::string>(
      "--policy",
      [&options](const std::string& text) {
        auto policy = parse_policy(text);
        if (!policy) throw CLI::ValidationError("--policy", policy.error().message);
        options.policy = *policy;
      },
      "lossless, or lossy:B with B bits a log-odds, 1 to 16: a new version of each tile "
      "[lossless]");
  app.add_option(
         "--max-load", options.max_load,
         "share of all processors, 0 to 1: while everybody else takes more, tiles wait, each "
         "at most a quarter of a second")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_flag_callback("--log-json", log_as_json, "log each event as one JSON object");
  app.set_config("--config", "", "read options from a TOML file");
  app.allow_config_extras(CLI::config_extras_mode::error);  // A misspelt key must not pass.
}

}  // namespace voxatlas
