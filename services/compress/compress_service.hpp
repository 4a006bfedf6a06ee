#pragma once

#include <cstdint>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

/// What a compressor does, without a network: a rested tile in, the same tile densely encoded out.
///
/// Source: DESIGN section 8. The result is decoded again and compared before it is sent: what comes
///         back to the store is the tile it gave.
/// Errors: kCorrupt for a payload that is no tile.
/// Threads: one at a time.
class CompressService {
 public:
  explicit CompressService(const CodecOptions& options);

  Result<tile_encoded_t> compress(const tile_raw_t& raw);

  struct Counters {
    std::uint64_t tiles = 0, refused = 0;
    std::uint64_t bytes_in = 0, bytes_out = 0;
    std::int64_t busy_us = 0;
  };
  const Counters& counters() const { return counters_; }

 private:
  CodecOptions options_;
  Counters counters_;
};

}  // namespace voxatlas
