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
  CodecOptions policy{TileCodec::kDense};
  /// Where work of ordinary priority takes more than this share of all processors, a tile waits,
  /// but no longer than a quarter of a second.
  double max_load = 0.8;
};

/// The process: joins the bus and works until a signal, at the lowest priority, so as to be in
/// nobody's way. Errors: what keeps it from starting, or from going on.
Status serve_compress(const CompressOptions& options);

}  // namespace voxatlas
