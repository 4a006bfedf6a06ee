#include "octree/brick_table.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a range made uniform is its bricks made so, one by one", "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 300; ++i) {
    TileTree tree;
    for (auto count = random.below(20); count > 0; --count) tree.set(random.cell(), random.state());
    BrickTable whole = tree.empty() ? BrickTable() : *tree.bricks();
    BrickTable one_by_one = whole;
    const auto depth = static_cast<int>(random.below(kBrickDepth + 1));
    const auto code = static_cast<std::uint32_t>(random.below(1u << 3 * depth));
    const auto range = BrickRange::of({static_cast<std::uint8_t>(depth), code});
    const auto state = random.state();
    whole.make_uniform(range, state);
    for (unsigned brick = 0; brick < range.count; ++brick) {
      one_by_one.make_uniform(range.first + brick, state);
    }
    REQUIRE(whole == one_by_one);
    REQUIRE(whole.uniform(range) == state);
  }
}

TEST_CASE("bricks that may be occupied are the mixed ones and the uniform ones that are",
          "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 100; ++i) {
    TileTree tree;
    for (auto count = random.below(20); count > 0; --count) tree.set(random.cell(), random.state());
    if (tree.empty()) continue;
    const BrickTable& table = *tree.bricks();
    const auto bricks = table.maybe_occupied();
    for (unsigned brick = 0; brick < kBricks; ++brick) {
      const bool expected = table.is_mixed(brick) ||
                            (table.is_uniform(brick) && is_occupied(table.uniform_log_odds(brick)));
      REQUIRE(((bricks[brick / 64] >> brick % 64 & 1) != 0) == expected);
    }
  }
}

}  // namespace
}  // namespace voxatlas
