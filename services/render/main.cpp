// voxatlas-render: requests in, pictures out.
//
//   in   VOXATLAS_RENDER_REQUEST     render_request_t   from anyone
//   in   VOXATLAS_TILE_UPDATE        tile_update_t      from tilestores
//   in   VOXATLAS_TILES_REPLY        tiles_reply_t      from tilestores
//   in   VOXATLAS_TILE_REPLY         tile_reply_t       from tilestores
//   in   VOXATLAS_MODEL_REPLY        model_reply_t      from tilestores, at start
//   out  VOXATLAS_FRAME              frame_t            JPEG, to anyone
//   out  VOXATLAS_CHUNK_CLIENT_p     chunk_t (frame_t)  PNG, reliable, to who asked
//   out  VOXATLAS_TILES_REQUEST, VOXATLAS_TILE_REQUEST, VOXATLAS_MODEL_REQUEST, VOXATLAS_STATUS
//
// It keeps a cache of tiles, nothing else: start as many as there are viewers to serve.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/log.hpp"
#include "bus/service_main.hpp"
#include "render/render_process.hpp"

namespace voxatlas {

static void declare(CLI::App& app, RenderProcessOptions& options);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::RenderProcessOptions options;
  CLI::App app{"voxatlas render: draws the model for whoever asks", "voxatlas-render"};
  voxatlas::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  return voxatlas::run_service(fmt::format("render[{}]", options.index),
                               voxatlas::Precedence::kFirst,
                               [&] { return voxatlas::serve_render(options); });
}

namespace voxatlas {

static void declare(CLI::App& app, RenderProcessOptions& options) {
  app.add_option("--url", options.url, "LCM URL of the bus")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  app.add_option("--index", options.index, "number of this renderer, told in its status")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--stores", options.stores, "how many tilestores (shards) the model has")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--cache-mb", options.cache_mb, "budget for tiles in memory, megabytes")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_flag_callback("--log-json", log_as_json, "log each event as one JSON object");
  app.add_option("--threads", options.threads, "that paint, and as many that build trees")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.set_config("--config", "", "read options from a TOML file");
  app.allow_config_extras(CLI::config_extras_mode::error);  // A misspelt key must not pass.
}

}  // namespace voxatlas
