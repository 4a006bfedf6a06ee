#include "codec/dense_stream.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "codec/fast_stream.hpp"
#include "codec/palette_code.hpp"
#include "codec/tile_codec.hpp"
#include "unit/codec/codec_trees.hpp"

namespace voxatlas {
namespace {

TEST_CASE("dense bytes and fast parts give back any tile", "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 200; ++i) {
    const auto tree = i % 2 == 0 ? test::random_tree(random) : test::scanned_tree(random);
    REQUIRE(decode_dense(encode_dense(tree)).value() == tree);
    const auto parts = encode_fast(tree);
    REQUIRE(parts.head.size() <= kMaxFastHead);
    REQUIRE(parts.body.size() <= kMaxFastBody);
    REQUIRE(decode_fast(parts.head, parts.body).value() == tree);
  }
}

TEST_CASE("a tile in which every voxel differs stays within the bounds", "[codec]") {
  TileTree tree;
  for (std::uint32_t code = 0; code < 1u << 21; ++code) {
    tree.set(CellKey{kDepth, code}, {static_cast<LogOdds>(code % 65'000 - 32'000), {}});
  }
  REQUIRE(can_be_dense(tree));
  REQUIRE(decode_dense(encode_dense(tree)).value() == tree);
  const auto parts = encode_fast(tree);
  REQUIRE(parts.head.size() <= kMaxFastHead);
  REQUIRE(parts.body.size() <= kMaxFastBody);
  REQUIRE(decode_fast(parts.head, parts.body).value() == tree);
}

TEST_CASE("every log-odds there is, -8 among them, is too much for dense bytes", "[codec]") {
  TileTree tree;
  for (std::uint32_t code = 0; code < 1u << 16; ++code) {
    tree.set(CellKey{kDepth, code}, {static_cast<LogOdds>(code), {}});
  }
  REQUIRE_FALSE(can_be_dense(tree));
  const auto bytes = encode_tile(tree, {TileCodec::kDense});
  REQUIRE(codec_of(bytes).value() == TileCodec::kFast);
  REQUIRE(decode_tile(bytes).value() == tree);
  REQUIRE(decode_tile_to_depth(bytes, 0).value().uniform(CellKey{})->log_odds == 32'767);
}

/// The highest log-odds below each cell of a depth, by asking the whole tile.
TileTree cut_by_asking(const TileTree& tree, int depth) {
  TileTree result;
  tree.for_each_cell(depth, [&](const Leaf& leaf) {
    result.set(leaf.cell, {leaf.state.log_odds, {}});
  });
  return result;
}

TileTree without_colour(const TileTree& tree) {
  TileTree result;
  tree.for_each_leaf([&](const Leaf& leaf) { result.set(leaf.cell, {leaf.state.log_odds, {}}); });
  return result;
}

TEST_CASE("decoded to a depth, a tile is what its cells of that depth say", "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 30; ++i) {
    const auto tree = i % 2 == 0 ? test::random_tree(random) : test::scanned_tree(random);
    const auto fast = encode_tile(tree, {TileCodec::kFast});
    const auto dense = encode_tile(tree, {TileCodec::kDense});
    for (int depth = 0; depth <= kDepth; ++depth) {
      const auto cut = decode_tile_to_depth(dense, depth).value();
      REQUIRE(without_colour(cut) == cut_by_asking(tree, depth));
      REQUIRE(cut == cut_tile(tree, depth));
      REQUIRE(decode_tile_to_depth(fast, depth).value() == cut);
    }
  }
}

TEST_CASE("a cell cut at depth 4 or above has the mean colour of its voxels", "[codec][oracle]") {
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 20; ++i) {
    const auto tree = test::scanned_tree(random);
    for (int depth = 0; depth <= kBrickDepth; ++depth) {
      const auto cut = cut_tile(tree, depth);
      tree.for_each_cell(depth, [&](const Leaf& leaf) {
        const auto state = cut.uniform(leaf.cell);
        REQUIRE(state.has_value());
        REQUIRE(state->colour.count == leaf.state.colour.count);
        for (std::size_t c = 0; c < 3; ++c) {  // A mean of rounded means: off by one at most.
          REQUIRE(std::abs(state->colour.mean[c] - leaf.state.colour.mean[c]) <= 1);
        }
      });
    }
  }
}

TEST_CASE("a palette of hits and misses costs less than a byte a value", "[codec][oracle]") {
  const auto model = SensorModel::standard();
  auto rng = test::engine();
  for (int i = 0; i < 100; ++i) {
    std::vector<LogOdds> palette;
    LogOdds value = 0;
    for (int step = 0; step < 60; ++step) {
      palette.push_back(value = model.update(value, rng() % 3 == 0 ? model.hit : model.miss));
    }
    if (i % 3 == 0) palette.push_back(static_cast<LogOdds>(rng()));  // Of no such history.
    std::sort(palette.begin(), palette.end());
    palette.erase(std::unique(palette.begin(), palette.end()), palette.end());
    Bytes bytes;
    RangeEncoder encoder(bytes);
    code_palette(encoder, palette);
    encoder.finish();
    REQUIRE(bytes.size() <= palette.size() + 4);
    RangeDecoder decoder(bytes);
    std::vector<LogOdds> back;
    REQUIRE(code_palette(decoder, back));
    REQUIRE(back == palette);
  }
}

TEST_CASE("any bytes are a tile or an error, to any depth", "[codec]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(rng() % 200);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    for (const int depth : {2, 5, 7}) {
      const auto tree = decode_dense(bytes, depth);
      if (!tree) REQUIRE(tree.error().code == ErrorCode::kCorrupt);
    }
    REQUIRE((bytes.empty() || !decode_fast(bytes, bytes).has_value()));
  }
}

}  // namespace
}  // namespace voxatlas
