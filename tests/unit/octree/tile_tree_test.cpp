#include "octree/tile_tree.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "support/dense_tile.hpp"
#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

using test::DenseTile;
using test::difference;

/// One random change to both; mostly near one corner, so that changes meet.
void change_both(TileTree& tree, DenseTile& dense, test::RandomOctree& random) {
  const CellKey cell = random.cell();
  const SensorModel& model = random.model();
  switch (random.below(16)) {
    case 0:
      tree.erase(cell);
      dense.erase(cell);
      break;
    case 1: {
      const CellState state = random.state();
      tree.set(cell, state);
      dense.set(cell, state);
      break;
    }
    case 2:
    case 3: {
      const TileDelta delta = random.delta();
      tree.apply(delta, model);
      dense.apply(delta, model);
      break;
    }
    case 4:
      tree.prune();
      break;
    case 5:
    case 6:
    case 7:
    case 8:
    case 9: {
      const auto seen = random.maybe_colour();
      tree.hit(cell, model, seen);
      dense.hit(cell, model, seen);
      break;
    }
    default:
      tree.miss(cell, model);
      dense.miss(cell, model);
  }
}

TEST_CASE("a TileTree is the dense array it stands for, after any changes", "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 12; ++round) {
    test::RandomOctree random(test::seed() + static_cast<unsigned>(round));
    TileTree tree;
    DenseTile dense;
    for (int step = 0; step < 120; ++step) change_both(tree, dense, random);
    INFO("round " << round);
    REQUIRE(difference(tree, dense) == "");
    const TileTree copy = tree;
    REQUIRE(copy == tree);
    const auto bytes = tree.memory_bytes();
    tree.prune();
    REQUIRE(tree.memory_bytes() <= bytes);
    REQUIRE(copy == tree);
    for (int step = 0; step < 20; ++step) change_both(tree, dense, random);
    REQUIRE(difference(tree, dense) == "");
  }
}

TEST_CASE("cell() and uniform() agree with a walk over the voxels, at every depth",
          "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  TileTree tree;
  DenseTile dense;
  for (int step = 0; step < 200; ++step) change_both(tree, dense, random);
  for (int i = 0; i < 300; ++i) {
    const CellKey cell = random.cell();
    CAPTURE(int{cell.depth}, cell.code);
    REQUIRE(tree.cell(cell) == dense.cell(cell));
    REQUIRE(tree.uniform(cell) == dense.uniform(cell));
  }
}

TEST_CASE("a tree made from another's leaves equals it", "[octree]") {
  test::RandomOctree random(test::seed());
  TileTree tree;
  DenseTile dense;
  for (int step = 0; step < 100; ++step) change_both(tree, dense, random);
  TileTree again;
  tree.for_each_leaf([&](const Leaf& leaf) { again.set(leaf.cell, leaf.state); });
  REQUIRE(again == tree);
  const CellState known = tree.leaves().front().state;
  again.set(tree.leaves().front().cell, {static_cast<LogOdds>(known.log_odds ^ 1), known.colour});
  REQUIRE_FALSE(again == tree);
}

TEST_CASE("a tile that knows nothing costs nothing and equals one that was erased", "[octree]") {
  TileTree tree;
  REQUIRE(tree.empty());
  REQUIRE(tree.memory_bytes() <= 64);
  REQUIRE(tree.leaves().empty());
  REQUIRE_FALSE(tree.cell({0, 0}).has_value());
  TileTree erased;
  erased.miss({7, 5}, SensorModel::standard());
  REQUIRE_FALSE(erased == tree);
  erased.erase({0, 0});
  REQUIRE(erased.empty());
  REQUIRE(erased == tree);
  erased.prune();
  REQUIRE(erased.memory_bytes() == tree.memory_bytes());
}

TEST_CASE("uniform space is one leaf, without a brick, whatever its history", "[octree]") {
  const SensorModel model = SensorModel::standard();
  TileTree tree;
  for (std::uint32_t code = 0; code < 8; ++code) tree.miss({1, code}, model);
  REQUIRE(tree.leaves() == std::vector<Leaf>{{{0, 0}, {model.miss, {}}}});
  REQUIRE(tree.memory_bytes() < 12'000);
  for (std::uint32_t code = 0; code < 8; ++code) tree.hit({7, code}, model);
  REQUIRE(tree.counts().leaves == 6 * 7 + 1);  // Seven siblings a depth, and the depth-6 cell.
  REQUIRE(tree.counts().inner == 6);
}

TEST_CASE("no voxel outside a cell is touched by it, not even clamped", "[octree]") {
  const SensorModel model = SensorModel::standard();
  TileTree tree;
  tree.set({4, 9}, {32767, {}});
  tree.miss({7, 9 * 512}, model);
  REQUIRE(tree.cell({7, 9 * 512 + 1})->log_odds == 32767);
  REQUIRE(tree.cell({7, 9 * 512})->log_odds == model.clamp_max);
}

}  // namespace
}  // namespace voxatlas
