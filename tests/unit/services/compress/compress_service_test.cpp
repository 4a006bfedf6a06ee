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

    const auto encoded = service.compress(raw);

    REQUIRE(encoded.has_value());
    REQUIRE(encoded->tile == raw.tile);
    REQUIRE(encoded->version == raw.version);
    REQUIRE(encoded->size == static_cast<std::int32_t>(encoded->payload.size()));
    REQUIRE(encoded->payload.size() <= raw.payload.size());
    REQUIRE(decode_tile(encoded->payload).value() == tree);
    REQUIRE(codec_of(encoded->payload).value() == TileCodec::kDense);
  }
  REQUIRE(service.counters().tiles == 5);
}

TEST_CASE("a payload that is no tile is refused with the tile's name", "[compress]") {
  CompressService service({TileCodec::kDense, 0});
  tile_raw_t raw{};
  raw.tile = 0xabc;
  raw.payload = {1, 2, 3};
  raw.size = 3;
  const auto encoded = service.compress(raw);
  REQUIRE_FALSE(encoded.has_value());
  REQUIRE(encoded.error().code == ErrorCode::kCorrupt);
  REQUIRE(encoded.error().message.find("0xabc") != std::string::npos);
  REQUIRE(service.counters().refused == 1);
}

}  // namespace
}  // namespace voxatlas
