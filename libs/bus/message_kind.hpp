#pragma once

#include <cstdint>

namespace voxatlas {

/// What a reliable message is: the LCM type whose encoded bytes it carries. Never renumber.
enum class MessageKind : std::int16_t {
  kScan = 1,         ///< scan_t, publisher -> ingest.
  kScanDelta = 2,    ///< scan_delta_t, ingest -> tilestore.
  kTileRaw = 3,      ///< tile_raw_t, tilestore -> compress.
  kTileEncoded = 4,  ///< tile_encoded_t, compress -> tilestore.
  kFrame = 5,        ///< frame_t, render -> client.
};

}  // namespace voxatlas
