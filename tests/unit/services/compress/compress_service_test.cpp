#include "compress/compress_service.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileTree some_tile(std::mt19937_64& rng) {
  TileTree tree;
  const auto model = SensorModel::standard();
  for (int i = 0; i < 3'000; ++i) {
    const auto depth = static_cast<std::uint8_t>(3 + rng() % 5);
    const CellKey cell{depth, static_cast<std::uint32_t>(rng() % (1u << 3 * depth))};
    rng() % 2 == 0 ? tree.miss(cell, model) : tree.hit(cell, model, Rgb{1, 2, 3});
  }
  return tree;
}

TEST_CASE("what a compressor sends back is the tile it was given", "[compress]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  CompressService service({TileCodec::kDense, 0});
  for (int i = 0; i < 5; ++i) {
    const TileTree tree = some_tile(rng);
    tile_raw_t raw{};
    raw.tile = 42 + i;
    raw.version = 7 + i;
    raw.payload = encode_tile(tree, {TileCodec::kFast, 0});
    raw.size = static_cast<std::int32_t>(raw.payload.size());
    raw.clamp_min = -8161;
    raw.clamp_max = 14'238;

    const auto encoded = service.compress(raw);

    REQUIRE(encoded.tile == raw.tile);
    REQUIRE(encoded.version == raw.version);
    REQUIRE(encoded.size == static_cast<std::int32_t>(encoded.payload.size()));
    REQUIRE(encoded.payload.size() <= raw.payload.size());
    REQUIRE(decode_tile(encoded.payload).value() == tree);
    REQUIRE(codec_of(encoded.payload).value() == TileCodec::kDense);
  }
  REQUIRE(service.counters().tiles == 5);
  REQUIRE(service.counters().bytes_out < service.counters().bytes_in);
  REQUIRE(service.counters().ratio() < 1);
}

TEST_CASE("a lossy policy sends what quantize() makes, within the clamps of the tile's model",
          "[compress]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  CompressService service(parse_policy("lossy:3").value());
  const TileTree tree = some_tile(rng);
  tile_raw_t raw{};
  raw.version = 7;
  raw.clamp_min = -3'000;
  raw.clamp_max = 9'000;
  raw.payload = encode_tile(tree, {TileCodec::kFast, 0});
  const auto encoded = service.compress(raw);
  REQUIRE(encoded.version == 7);
  const auto how = quantization_of(encoded.payload).value();
  REQUIRE(how == Quantization{3, 5, -3'000, 9'000});
  REQUIRE(decode_tile(encoded.payload).value() == quantize(tree, how));
  REQUIRE(same_occupancy(decode_tile(encoded.payload).value(), tree));
}

TEST_CASE("a policy is lossless, or lossy with 1 to 16 bits, and nothing else", "[compress]") {
  REQUIRE(parse_policy("lossless").value().codec == TileCodec::kDense);
  for (int bits = 1; bits <= 16; ++bits) {
    const auto policy = parse_policy("lossy:" + std::to_string(bits));
    REQUIRE(policy->codec == TileCodec::kLossy);
    REQUIRE(policy->lossy.bits == bits);
  }
  for (const char* text : {"", "lossy", "lossy:", "lossy:0", "lossy:17", "lossy:6x", "lossy: 6",
                           "Lossless", "lossless "}) {
    CAPTURE(text);
    REQUIRE(parse_policy(text).error().code == ErrorCode::kInvalid);
  }
}

TEST_CASE("a payload that is no tile is answered by none", "[compress]") {
  CompressService service({TileCodec::kDense, 0});
  tile_raw_t raw{};
  raw.tile = 0xabc;
  raw.version = 4;
  raw.clamp_min = -1;
  raw.payload = {1, 2, 3};
  raw.size = 3;
  const auto encoded = service.compress(raw);
  REQUIRE(encoded.tile == 0xabc);
  REQUIRE(encoded.version == 4);
  REQUIRE(encoded.size == 0);
  REQUIRE(encoded.payload.empty());
  REQUIRE(service.counters().refused == 1);
}

}  // namespace
}  // namespace voxatlas
