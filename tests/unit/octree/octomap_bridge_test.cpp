#include "octree/octomap_bridge.hpp"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <catch2/catch.hpp>

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

octomap::OcTreeKey key_of(const Index3& voxel) {
  return {static_cast<octomap::key_type>(32768 + voxel[0]),
          static_cast<octomap::key_type>(32768 + voxel[1]),
          static_cast<octomap::key_type>(32768 + voxel[2])};
}

float octomap_log_odds(LogOdds log_odds) { return static_cast<float>(log_odds) / 4096.0f; }

TileTree random_tile(test::RandomOctree& random) {
  TileTree tree;
  for (int i = 0; i < 60; ++i) {
    tree.miss(random.cell_at(static_cast<int>(3 + random.below(5))), random.model());
    tree.hit(random.cell_at(static_cast<int>(4 + random.below(4))), random.model(),
             random.maybe_colour());
    tree.set(random.cell_at(7), random.state());
    tree.apply(random.delta(), random.model());
  }
  return tree;
}

TEST_CASE("an OctoMap tree fed the same updates has the same log-odds, bit for bit",
          "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  const SensorModel model = SensorModel::standard();
  octomap::OcTree oracle(0.1);
  oracle.setClampingThresMin(to_probability(model.clamp_min));
  oracle.setClampingThresMax(to_probability(model.clamp_max));
  oracle.setProbHit(to_probability(model.hit));
  oracle.setProbMiss(to_probability(model.miss));
  REQUIRE(oracle.getClampingThresMinLog() == octomap_log_odds(model.clamp_min));
  REQUIRE(oracle.getClampingThresMaxLog() == octomap_log_odds(model.clamp_max));
  TileTree tree;
  for (int i = 0; i < 60'000; ++i) {
    // A walk that stays near its places: runs of misses that fill whole cells, and hits.
    const CellKey cell{7, random.cell_at(6).code * 8 + static_cast<std::uint32_t>(i) % 8};
    const bool is_hit = random.below(3) == 0;
    is_hit ? tree.hit(cell, model) : tree.miss(cell, model);
    oracle.updateNode(key_of(cell.min_voxel()), is_hit);
  }
  oracle.updateInnerOccupancy();
  oracle.prune();
  std::size_t voxels = 0;
  for (std::uint32_t code = 0; code < 1u << 21; ++code) {
    const CellKey voxel{7, code};
    const auto own = tree.cell(voxel);
    const auto* node = oracle.search(key_of(voxel.min_voxel()));
    if (own.has_value() != (node != nullptr) ||
        (own && octomap_log_odds(own->log_odds) != node->getLogOdds())) {
      FAIL("voxel " << code << " differs");
    }
    voxels += own.has_value();
  }
  REQUIRE(voxels > 10'000);
  for (int depth = 1; depth < kDepth; ++depth) {
    for (int i = 0; i < 200; ++i) {
      const CellKey cell = random.cell_at(depth);
      const auto* node = oracle.search(key_of(cell.min_voxel()), static_cast<unsigned>(depth) + 9);
      const auto own = tree.cell(cell);
      REQUIRE(own.has_value() == (node != nullptr));
      if (own) REQUIRE(octomap_log_odds(own->log_odds) == node->getLogOdds());
    }
  }
}

TEST_CASE("a tile in OctoMap's form has its leaves, colours and inner maxima", "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  const TileTree tree = random_tile(random);
  const auto octomap_tree = to_octomap(tree, Grid::standard());
  REQUIRE(octomap_tree->getResolution() == 0.1);
  REQUIRE(octomap_tree->getNumLeafNodes() == tree.counts().leaves);
  REQUIRE(octomap_tree->size() == octomap_tree->calcNumNodes());
  tree.for_each_leaf([&](const Leaf& leaf) {
    const auto key = key_of(leaf.cell.min_voxel());
    const auto* node = octomap_tree->search(key, leaf.cell.depth + 9u);
    if (node == nullptr || node->getLogOdds() != octomap_log_odds(leaf.state.log_odds) ||
        octomap_tree->nodeHasChildren(node) || node->isColorSet() != leaf.state.colour.exists()) {
      FAIL("leaf " << int{leaf.cell.depth} << " " << leaf.cell.code << " differs");
    }
  });
  for (int i = 0; i < 500; ++i) {
    const CellKey cell = random.cell();
    if (tree.uniform(cell)) continue;
    const auto* node = octomap_tree->search(key_of(cell.min_voxel()), cell.depth + 9u);
    const auto own = tree.cell(cell);
    if (own) REQUIRE(node->getLogOdds() == octomap_log_odds(own->log_odds));
  }
}

TEST_CASE("a tile comes back from OctoMap's form, but for count, fraction and white", "[octree]") {
  INFO("VOX_SEED=" << test::seed());
  const Grid grid = Grid::create(GENERATE(1, 3, 7, 10, 20)).value();
  test::RandomOctree random(test::seed());
  TileTree tree = random_tile(random);
  tree.set({7, 3}, {5, {{0xffff, 0xff00, 0xff80}, 3}});
  TileTree wanted;
  tree.for_each_leaf([&](const Leaf& leaf) {
    CellState state{leaf.state.log_odds, {}};
    if (leaf.state.colour.exists()) {
      const Rgb rgb = leaf.state.colour.rgb();
      state.colour.add(rgb == Rgb{255, 255, 255} ? Rgb{254, 254, 254} : rgb);
    }
    wanted.set(leaf.cell, state);
  });
  const auto back = from_octomap(*to_octomap(tree, grid), grid);
  REQUIRE(back.has_value());
  REQUIRE(*back == wanted);
  REQUIRE(back->cell({7, 3})->colour.rgb() == Rgb{254, 254, 254});
}

TEST_CASE("an empty tile is an empty OctoMap tree and back", "[octree]") {
  const auto octomap_tree = to_octomap({}, Grid::standard());
  REQUIRE(octomap_tree->size() == 0);
  REQUIRE(from_octomap(*octomap_tree, Grid::standard())->empty());
}

TEST_CASE("a whole tile of one state is one node", "[octree]") {
  TileTree tree;
  tree.set({0, 0}, {-77, {}});
  const auto octomap_tree = to_octomap(tree, Grid::standard());
  REQUIRE(octomap_tree->getNumLeafNodes() == 1);
  REQUIRE(from_octomap(*octomap_tree, Grid::standard()).value() == tree);
}

/// A tree whose root can be made a leaf, as a hostile file may.
struct RootLeaf : octomap::ColorOcTree {
  using octomap::ColorOcTree::ColorOcTree;
  void make() {
    root = new octomap::ColorOcTreeNode;
    ++tree_size;
  }
};

TEST_CASE("an OctoMap tree that is no tile is refused, with the reason", "[octree][hostile]") {
  const auto refused = [](const octomap::ColorOcTree& octomap_tree, const char* what) {
    const auto tree = from_octomap(octomap_tree, Grid::standard());
    REQUIRE_FALSE(tree.has_value());
    REQUIRE(tree.error().code == ErrorCode::kOutOfRange);
    REQUIRE_THAT(tree.error().message, Catch::Contains(what));
  };
  octomap::ColorOcTree coarse(0.2);
  refused(coarse, "resolution 0.2");
  for (const float bad : {8.0f, -8.0f, 7.99999f, std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()}) {
    octomap::ColorOcTree loud(0.1);
    loud.setNodeValue(key_of({1, 2, 3}), 0.5f);
    loud.search(key_of({1, 2, 3}))->setLogOdds(bad);
    refused(loud, "log-odds");
  }
  for (const auto& key : {octomap::OcTreeKey(32767, 32768, 32768),
                          octomap::OcTreeKey(32768, 32896, 32768), octomap::OcTreeKey(0, 0, 0)}) {
    octomap::ColorOcTree outside(0.1);
    outside.setNodeValue(key, 0.5f);
    refused(outside, "not inside");
  }
  RootLeaf huge(0.1);
  huge.make();
  refused(huge, "depth 0");
}

TEST_CASE("OctoMap's log-odds are rounded to the lattice, and free colours dropped", "[octree]") {
  octomap::ColorOcTree octomap_tree(0.1);
  octomap_tree.setNodeValue(key_of({0, 0, 0}), 0.4f / 4096);
  octomap_tree.setNodeValue(key_of({127, 127, 127}), -1.6f / 4096);
  octomap_tree.setNodeColor(key_of({0, 0, 0}), 1, 2, 3);
  octomap_tree.setNodeColor(key_of({127, 127, 127}), 1, 2, 3);
  const auto tree = from_octomap(octomap_tree, Grid::standard());
  REQUIRE(tree.has_value());
  REQUIRE(tree->voxel({0, 0, 0}) == CellState{0, {{256, 512, 768}, 1}});
  REQUIRE(tree->voxel({127, 127, 127}) == CellState{-2, {}});
}

}  // namespace
}  // namespace voxatlas
