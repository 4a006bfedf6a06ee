#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"
#include "bus/bus_url.hpp"

namespace voxatlas {

struct IngestOptions {
  std::string url = kDefaultBusUrl;
  std::int32_t index = 0;
  std::int32_t ingests = 1;
  std::int32_t stores = 1;
  int workers = 1;
};

/// The process: joins the bus, asks every shard for the model's parameters, then works until a
/// signal. Errors: what keeps it from starting, or from going on.
Status serve_ingest(const IngestOptions& options);

}  // namespace voxatlas
