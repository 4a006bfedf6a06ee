#include "compress/compress_service.hpp"

#include <fmt/format.h>

#include <charconv>

#include "base/check.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"

namespace voxatlas {

Result<CodecOptions> parse_policy(std::string_view text) {
  constexpr std::string_view kLossy = "lossy:";
  if (text == "lossless") return CodecOptions{TileCodec::kDense};
  CodecOptions policy{TileCodec::kLossy};
  if (text.starts_with(kLossy)) {
    const auto bits = text.substr(kLossy.size());
    const auto [end, error] =
        std::from_chars(bits.data(), bits.data() + bits.size(), policy.lossy.bits);
    const bool whole = error == std::errc{} && end == bits.data() + bits.size();
    if (whole && policy.lossy.check()) return policy;
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("\"{}\" is no policy: lossless, or lossy:1 to lossy:16", text));
}

CompressService::CompressService(const CodecOptions& policy) : policy_(policy) {}

tile_encoded_t CompressService::compress(const tile_raw_t& raw) {
  const std::int64_t start = steady_utime();
  tile_encoded_t encoded{};
  encoded.tile = raw.tile;
  encoded.version = raw.version;
  const auto tree = decode_tile(raw.payload);
  if (!tree) {
    ++counters_.refused;
    log_warning("tile {:#x} version {} refused: {}", static_cast<std::uint64_t>(raw.tile),
                raw.version, tree.error().message);
    encoded.utime = utime_now();
    return encoded;
  }
  CodecOptions how = policy_;
  how.lossy.clamp_min = raw.clamp_min;
  how.lossy.clamp_max = raw.clamp_max;
  encoded.payload = encode_tile(*tree, how);
  const auto again = decode_tile(encoded.payload);
  const bool lossy = codec_of(encoded.payload).value() == TileCodec::kLossy;
  VOX_CHECK(again && *again == (lossy ? quantize(*tree, how.lossy) : *tree));
  encoded.utime = utime_now();
  encoded.size = static_cast<std::int32_t>(encoded.payload.size());
  ++counters_.tiles;
  counters_.bytes_in += raw.payload.size();
  counters_.bytes_out += encoded.payload.size();
  counters_.busy_us += steady_utime() - start;
  return encoded;
}

}  // namespace voxatlas
