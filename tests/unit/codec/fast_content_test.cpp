#include "codec/fast_content.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "codec/fast_stream.hpp"
#include "codec/pyramid.hpp"
#include "unit/codec/codec_trees.hpp"

namespace voxatlas {
namespace {

/// Ground, exceptions and highest are what the pyramid finds in its own way: by counting places.
void require_as_the_pyramid(const TileTree& tree) {
  const auto pyramid = pyramid_of(*tree.bricks());
  const auto parts = encode_fast(tree);
  const auto head = decode_fast_head(parts.head).value();
  REQUIRE(head.pyramid.palette == pyramid.palette);
  for (unsigned i = 0; i < kBricks; ++i) {
    INFO("slot " << i);
    const auto &mine = head.pyramid.slots[i], &oracle = pyramid.slots[i];
    REQUIRE(mine.kind == oracle.kind);
    REQUIRE(mine.ground == oracle.ground);
    REQUIRE(mine.highest == oracle.highest);
  }
  const auto content = fast_content_of(*tree.bricks());
  REQUIRE(content.masks.size() == pyramid.bricks.size() * kMaskBytes);
  for (std::size_t i = 0; i < pyramid.bricks.size(); ++i) {
    const auto* mask = content.masks.data() + i * kMaskBytes;
    REQUIRE(std::equal(mask, mask + kMaskBytes, pyramid.bricks[i].voxel_mask()));
  }
}

TEST_CASE("the fast codec finds the grounds and exceptions that the pyramid does",
          "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 100; ++i) {
    const auto tree = i % 2 == 0 ? test::random_tree(random) : test::scanned_tree(random);
    if (!tree.empty()) require_as_the_pyramid(tree);
  }
}

/// Bricks of a few contents, unknown among them, in shares on both sides of a half.
TileTree tree_of_shares() {
  auto rng = test::engine();
  constexpr LogOdds kValues[] = {0, -1, 1, -1661, 3471, 32'767, -32'768};
  TileTree tree;
  for (std::uint32_t brick = 0; brick < kBricks; brick += 13) {
    const std::uint32_t share = 254 + static_cast<std::uint32_t>(rng() % 5);
    const std::size_t most = rng() % 8, others = rng() % 8, kinds = 1 + rng() % 3;
    for (std::uint32_t voxel = 0; voxel < kBrickVoxels; ++voxel) {
      const std::size_t which = voxel < share ? most : others + rng() % kinds;
      if (which % 8 == 7) continue;  // Unknown.
      // Where the share begins differs from brick to brick.
      const std::uint32_t code = (voxel + 64 * (brick % 8)) % kBrickVoxels;
      tree.set(CellKey{kDepth, brick * kBrickVoxels + code}, {kValues[which % 8], {}});
    }
  }
  return tree;
}

TEST_CASE("a brick's ground is its commonest content, whatever is nearly as common",
          "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  const auto tree = tree_of_shares();
  require_as_the_pyramid(tree);
  const auto parts = encode_fast(tree);
  REQUIRE(decode_fast(parts.head, parts.body).value() == tree);
}

}  // namespace
}  // namespace voxatlas
