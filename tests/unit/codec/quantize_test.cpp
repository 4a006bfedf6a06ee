#include "codec/quantize.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "unit/codec/codec_trees.hpp"

namespace voxatlas {
namespace {

TEST_CASE("no log-odds changes side, clamps stay, the step holds, at every width",
          "[codec][oracle]") {
  TileTree tree;
  std::uint32_t code = 0;
  for (int value = -8161; value <= 14'238; ++value, ++code) {
    tree.set(CellKey{kDepth, code}, {static_cast<LogOdds>(value), {}});
  }
  for (int bits = 1; bits <= 16; ++bits) {
    const Quantization how{bits, 5};
    const double levels = std::max(1, (1 << (bits - 1)) - 1);
    const auto coarse = quantize(tree, how);
    std::set<LogOdds> values;
    for (std::uint32_t i = 0; i < code; ++i) {
      const auto before = static_cast<LogOdds>(static_cast<int>(i) - 8161);
      const LogOdds after = coarse.uniform(CellKey{kDepth, i})->log_odds;
      const double width = (is_occupied(before) ? 0.97 : 0.88) - 0.5;
      const double moved = std::abs(to_probability(before) - to_probability(after));
      const bool held = is_occupied(before) == is_occupied(after) && moved <= width / levels + 1e-4;
      if (!held) {
        CAPTURE(bits, before, after);
        REQUIRE(held);
      }
      values.insert(after);
    }
    REQUIRE(coarse.uniform(CellKey{kDepth, 0})->log_odds == -8161);
    REQUIRE(coarse.uniform(CellKey{kDepth, code - 1})->log_odds == 14'238);
    REQUIRE(values.size() <= std::size_t{1} << bits);
  }
}

TEST_CASE("a lossy tile keeps what is known, occupied and at its clamp", "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 60; ++i) {
    const auto tree = test::scanned_tree(random);
    const Quantization how{1 + i % 16, i % 9};
    const LogOddsQuantizer quantizer(how);
    const auto coarse = quantize(tree, how);
    REQUIRE(coarse.counts().occupied_voxels == tree.counts().occupied_voxels);
    REQUIRE(coarse.counts().free_voxels == tree.counts().free_voxels);
    tree.for_each_leaf([&](const Leaf& leaf) {
      // A leaf may have become part of a larger one, never of smaller ones.
      const auto after = coarse.uniform(leaf.cell);
      REQUIRE(after.has_value());
      const bool occupied = is_occupied(leaf.state.log_odds);
      REQUIRE(is_occupied(after->log_odds) == occupied);
      REQUIRE(std::abs(to_probability(after->log_odds) - to_probability(leaf.state.log_odds)) <=
              quantizer.step(occupied));
      if (leaf.state.log_odds == how.clamp_min || leaf.state.log_odds == how.clamp_max) {
        REQUIRE(after->log_odds == leaf.state.log_odds);
      }
      REQUIRE(after->colour == quantize(leaf.state.colour, how.colour_bits));
    });
  }
}

TEST_CASE("a lossy tile goes on living: updates add to its values", "[codec]") {
  test::RandomOctree random(test::seed());
  const auto model = SensorModel::standard();
  auto coarse = quantize(test::golden_tree(), Quantization{4, 5});
  const auto before = coarse.uniform(CellKey{kDepth, 1000});
  coarse.hit(CellKey{kDepth, 1000}, model);
  REQUIRE(coarse.uniform(CellKey{kDepth, 1000})->log_odds ==
          model.update(before->log_odds, model.hit));
}

TEST_CASE("a quantised colour is its nearest of 2^bits, its count kept", "[codec][oracle]") {
  for (int bits = 1; bits <= 8; ++bits) {
    const int steps = (1 << bits) - 1;
    for (int mean = 0; mean <= 255 * 256; mean += 13) {
      const Colour colour{{static_cast<std::uint16_t>(mean), 0, 255 * 256}, 7};
      const Colour after = quantize(colour, bits);
      const double error = std::abs(after.mean[0] - mean) / 256.0;
      if (error > 255.0 / steps / 2 + 0.51) {
        CAPTURE(bits, mean, after.mean[0]);
        REQUIRE(error <= 255.0 / steps / 2 + 0.51);
      }
      if (after.count != 7 || after.mean[1] != 0 || after.mean[2] != 255 * 256) {
        FAIL("black, white or the count changed");
      }
    }
  }
  REQUIRE_FALSE(quantize(Colour{{1, 2, 3}, 4}, 0).exists());
  REQUIRE_FALSE(quantize(Colour{}, 3).exists());
}

TEST_CASE("a quantisation that cannot be is refused by name", "[codec]") {
  REQUIRE(Quantization{}.check().has_value());
  REQUIRE(Quantization{0, 5}.check().error().message.find("0 bits a log-odds") == 0);
  REQUIRE(Quantization{17, 5}.check().error().code == ErrorCode::kOutOfRange);
  REQUIRE(Quantization{6, 9}.check().error().code == ErrorCode::kOutOfRange);
  REQUIRE(Quantization{6, 5, 0, 5}.check().error().code == ErrorCode::kOutOfRange);
  REQUIRE(Quantization{6, 5, -5, -1}.check().error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
