#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"
#include "bus/bus_url.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

struct CompressOptions {
  std::string url = kDefaultBusUrl;
  std::int32_t index = 0;
  std::int32_t stores = 1;
  CodecOptions codec{TileCodec::kDense, 0};
};

/// The process: joins the bus and works until a signal, at a low priority, so as to be in nobody's
/// way. Errors: what keeps it from starting, or from going on.
Status serve_compress(const CompressOptions& options);

}  // namespace voxatlas
