// voxatlas-ingest: scans in, tile deltas out.
//
//   in   VOXATLAS_CHUNK_INGEST_i   chunk_t (scan_t)         reliable, from publishers
//   in   VOXATLAS_SCAN             scan_t                   plain, from loggers
//   in   VOXATLAS_MODEL_REPLY      model_reply_t            from tilestores, at start
//   out  VOXATLAS_CHUNK_STORE_s    chunk_t (scan_delta_t)   reliable, to every tilestore
//   out  VOXATLAS_MODEL_REQUEST    model_request_t          to tilestores, at start
//   out  VOXATLAS_ACK, VOXATLAS_STATUS
//
// It keeps nothing: what it has not handed on durably, its publishers still hold and send again.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/log.hpp"
#include "bus/service_main.hpp"
#include "ingest/ingest_process.hpp"

namespace voxatlas {

static void declare(CLI::App& app, IngestOptions& options);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::IngestOptions options;
  CLI::App app{"voxatlas ingest: turns laser scans into tile deltas", "voxatlas-ingest"};
  voxatlas::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  return voxatlas::run_service(fmt::format("ingest[{}]", options.index),
                               voxatlas::Precedence::kIngest,
                               [&] { return voxatlas::serve_ingest(options); });
}

namespace voxatlas {

static void declare(CLI::App& app, IngestOptions& options) {
  app.add_option("--url", options.url, "LCM URL of the bus")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  app.add_option("--index", options.index, "number of this ingest, 0 to ingests - 1")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--ingests", options.ingests, "how many ingests share the plain scans")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--stores", options.stores, "how many tilestores (shards) the model has")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--workers", options.workers, "integration threads; scans are spread over them")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_flag_callback("--log-json", log_as_json, "log each event as one JSON object");
  app.set_config("--config", "", "read options from a TOML file");
  app.allow_config_extras(CLI::config_extras_mode::error);  // A misspelt key must not pass.
}

}  // namespace voxatlas
