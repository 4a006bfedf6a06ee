#include "render/render_tree.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "grid/grid.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileTree random_tile(std::mt19937_64& rng) {
  TileTree tile;
  std::uniform_int_distribution<std::uint32_t> place(0, 127);
  std::uniform_int_distribution<int> depth(2, 7), log_odds(-3000, 3000), level(0, 255);
  for (int i = 0; i < 400; ++i) {
    const int d = i < 6 ? depth(rng) : 5 + i % 3;
    CellState state{static_cast<LogOdds>(log_odds(rng)), {}};
    if (is_occupied(state.log_odds) && i % 2 == 0) {
      const auto grey = static_cast<std::uint8_t>(level(rng));
      state.colour.add({grey, static_cast<std::uint8_t>(255 - grey), 7});
    }
    tile.set(CellKey::of_voxel({place(rng), place(rng), place(rng)}, d), state);
  }
  return tile;
}

/// Walks a tree from its root by its children alone.
void walk(const RenderTree& tree, std::uint32_t node, CellKey cell,
          std::map<CellKey, std::uint32_t>& found) {
  REQUIRE(found.emplace(cell, node).second);
  if (cell.depth == kDepth) return;
  const TreeChildren children = tree.children(node);
  std::uint32_t child = children.first;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if ((children.octants & 1u << octant) != 0) walk(tree, child++, cell.child(octant), found);
  }
}

TEST_CASE("a render tree has the tile's occupied cells at every depth", "[render_tree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 5; ++round) {
    const TileTree tile = random_tile(rng);
    const RenderTree tree(tile, 17);
    REQUIRE(tree.version() == 17);
    std::map<CellKey, std::uint32_t> found;
    walk(tree, 0, {0, 0}, found);
    REQUIRE(found.size() == tree.node_count());
    for (int depth = 0; depth <= kDepth; ++depth) {
      std::uint64_t cells = 0;
      tile.for_each_cell(depth, [&](const Leaf& leaf) {
        if (!is_occupied(leaf.state.log_odds)) return;
        ++cells;
        const auto at = found.find(leaf.cell);
        REQUIRE(at != found.end());
        const std::uint32_t node = at->second;
        REQUIRE(tree.key_of(node) == leaf.cell);
        REQUIRE(tree.depth_of(node) == leaf.cell.depth);
        REQUIRE(leaf.state.log_odds - tree.paint(node).log_odds() <= 127);
        REQUIRE(leaf.state.log_odds >= tree.paint(node).log_odds());
        REQUIRE(tree.paint(node).coloured() == leaf.state.colour.exists());
        if (leaf.state.colour.exists()) REQUIRE(tree.paint(node).rgb() == leaf.state.colour.rgb());
      });
      REQUIRE(tree.cell_count(depth) == cells);
    }
  }
}

TEST_CASE("a paint keeps a normal to two degrees", "[render_tree]") {
  auto rng = test::engine();
  std::normal_distribution<float> side;
  REQUIRE(CellPaint({100, {}}, Eigen::Vector3f::Zero()).normal().isZero());
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Vector3f normal(side(rng), side(rng), side(rng));
    for (int axis = 0; axis < 3; ++axis) {
      if (i % 5 == axis) normal[axis] = 0;
    }
    normal.normalize();
    const Eigen::Vector3f kept = CellPaint({100, {}}, normal).normal();
    CAPTURE(normal.transpose(), kept.transpose());
    REQUIRE(kept.cross(normal).norm() < 0.035f);
    REQUIRE(kept.dot(normal) > 0);
  }
}

TEST_CASE("a tile with nothing occupied has an empty render tree", "[render_tree]") {
  TileTree tile;
  REQUIRE(RenderTree(tile).empty());
  tile.set({3, 5}, {-100, {}});
  REQUIRE(RenderTree(tile).empty());
  tile.set({0, 0}, {100, {}});
  const RenderTree full(tile);
  REQUIRE(full.node_count() == 1);
  REQUIRE(full.links().size() == 1);
  REQUIRE(full.children(0).octants == 0);
  REQUIRE(full.cell_count(0) == 1);
  REQUIRE(full.cell_count(7) == 1);
}

TEST_CASE("numbers find their tree and node, over empty trees too", "[render_tree]") {
  TileTree one, none;
  one.set({7, 0}, {100, {}});
  const RenderTree trees[] = {RenderTree(none), RenderTree(one), RenderTree(none), RenderTree(one)};
  const TileKey key = Grid::standard().tile_at({4.1e6, 8e5, 4.7e6}).value();
  std::vector<PlacedTree> placed;
  for (const auto& tree : trees) placed.push_back({key, &tree});
  const TreeNumbers numbers(placed);
  REQUIRE(numbers.count() == 16);
  for (std::uint32_t number = 1; number <= 16; ++number) {
    const auto found = numbers.find(number);
    REQUIRE(found.tree == (number <= 8 ? 1 : 3));
    REQUIRE(found.node == (number - 1) % 8);
    REQUIRE(numbers.depth(found) == static_cast<int>(found.node));
  }
}

}  // namespace
}  // namespace voxatlas
