#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.hpp"
#include "bus/bus_url.hpp"

namespace voxatlas {

struct RenderProcessOptions {
  std::string url = kDefaultBusUrl;
  std::int32_t index = 0;
  std::int32_t stores = 1;
  std::size_t cache_mb = 256;
  std::size_t threads = 2;  ///< That paint, and as many that build trees.
};

/// The process: joins the bus, asks every shard for the model's parameters, then draws until a
/// signal. Errors: what keeps it from starting, or from going on.
Status serve_render(const RenderProcessOptions& options);

}  // namespace voxatlas
