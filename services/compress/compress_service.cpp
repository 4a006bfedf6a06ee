#include "compress/compress_service.hpp"

#include <fmt/format.h>

#include "base/check.hpp"
#include "base/utime.hpp"

namespace voxatlas {

CompressService::CompressService(const CodecOptions& options) : options_(options) {}

Result<tile_encoded_t> CompressService::compress(const tile_raw_t& raw) {
  const std::int64_t start = steady_utime();
  auto tree = decode_tile(raw.payload);
  if (!tree) {
    ++counters_.refused;
    return pass_on(tree, fmt::format("tile {:#x} version {}", static_cast<std::uint64_t>(raw.tile),
                                     raw.version));
  }
  tile_encoded_t encoded{};
  encoded.payload = encode_tile(*tree, options_);
  const auto again = decode_tile(encoded.payload);
  VOX_CHECK(again && *again == *tree);
  encoded.utime = utime_now();
  encoded.tile = raw.tile;
  encoded.version = raw.version;
  encoded.size = static_cast<std::int32_t>(encoded.payload.size());
  ++counters_.tiles;
  counters_.bytes_in += raw.payload.size();
  counters_.bytes_out += encoded.payload.size();
  counters_.busy_us += steady_utime() - start;
  return encoded;
}

}  // namespace voxatlas
