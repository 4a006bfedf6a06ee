#pragma once

#include <cstdint>
#include <string_view>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

/// `lossless`, or `lossy:B`, B the bits of a log-odds, 1..16. Errors: kInvalid, saying what is
/// possible.
Result<CodecOptions> parse_policy(std::string_view text);

/// What a compressor does, without a network: a rested tile in, the same tile densely encoded out,
/// or a coarser one.
///
/// Source: DESIGN section 8. The result is decoded again and compared before it is sent: what comes
///         back to the store is the tile it gave, or exactly what quantize() makes of it.
/// Refused: for a payload that is no tile the result has none either, so that the store hears of it
///         and does not wait.
/// Threads: one at a time.
class CompressService {
 public:
  /// Of a lossy policy the clamps are those that come with each tile.
  explicit CompressService(const CodecOptions& policy);

  tile_encoded_t compress(const tile_raw_t& raw);

  struct Counters {
    std::uint64_t tiles = 0, refused = 0;
    std::uint64_t bytes_in = 0, bytes_out = 0;
    std::int64_t busy_us = 0;

    double ratio() const {  ///< Bytes out for a byte in; 1 before the first tile.
      return bytes_in == 0 ? 1 : static_cast<double>(bytes_out) / static_cast<double>(bytes_in);
    }
  };
  const Counters& counters() const { return counters_; }

 private:
  CodecOptions policy_;
  Counters counters_;
};

}  // namespace voxatlas
