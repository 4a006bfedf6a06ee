#include "render/cell_cloud.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Place = std::array<int, 3>;

/// Blobs of occupied and free cells at mixed depths, some coloured.
TileTree random_tree(std::mt19937_64& rng) {
  TileTree tree;
  for (int i = 0; i < 60; ++i) {
    const auto depth = static_cast<std::uint8_t>(2 + rng() % 6);
    const CellKey cell{depth, static_cast<std::uint32_t>(rng() % (1u << 3 * depth))};
    CellState state{static_cast<LogOdds>(rng() % 3 == 0 ? -2000 : 4000), {}};
    if (state.log_odds > 0 && rng() % 2 == 0) state.colour.add({200, 100, 50});
    tree.set(cell, state);
  }
  for (int i = 0; i < 300; ++i) {
    tree.set({kDepth, static_cast<std::uint32_t>(rng() % 4096)}, {3000, {}});
  }
  return tree;
}

/// Oracle: what is occupied, cell by cell, asked of the tree one at a time.
class Dense {
 public:
  Dense(const TileTree& tree, int depth) : edge_(1 << depth) {
    for (std::uint32_t code = 0; code < 1u << 3 * depth; ++code) {
      const auto state = tree.cell({static_cast<std::uint8_t>(depth), code});
      const Index3 at = morton_decode(code);
      if (state && is_occupied(state->log_odds)) {
        occupied_[{int(at[0]), int(at[1]), int(at[2])}] = true;
      }
    }
  }

  bool occupied(const Place& at) const { return occupied_.contains(at); }

  /// Seen from outside: some cell beside the block min..min+size is not occupied, or off the tile.
  bool exposed(const Place& min, int size) const {
    for (int x = -1; x <= size; ++x) {
      for (int y = -1; y <= size; ++y) {
        for (int z = -1; z <= size; ++z) {
          const int outside = (x < 0 || x == size) + (y < 0 || y == size) + (z < 0 || z == size);
          if (outside != 1) continue;
          if (!occupied({min[0] + x, min[1] + y, min[2] + z})) return true;
        }
      }
    }
    return false;
  }

 private:
  int edge_;
  std::map<Place, bool> occupied_;
};

TEST_CASE("a cloud draws every occupied cell that can be seen, and no other", "[cloud][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int depth = 0; depth <= 6; ++depth) {
    const TileTree tree = random_tree(rng);
    const Dense dense(tree, depth);
    std::map<Place, Leaf> expected;
    tree.for_each_cell(depth, [&](const Leaf& leaf) {
      const int shift = kDepth - depth;
      const Index3 voxel = leaf.cell.min_voxel();
      const int size = int(leaf.cell.edge_voxels()) >> shift;
      const Place min{int(voxel[0]) >> shift, int(voxel[1]) >> shift, int(voxel[2]) >> shift};
      if (!is_occupied(leaf.state.log_odds) || !dense.exposed(min, size)) return;
      const int edge = int(leaf.cell.edge_voxels());
      expected.emplace(
          Place{int(voxel[0]) * 2 + edge, int(voxel[1]) * 2 + edge, int(voxel[2]) * 2 + edge},
          leaf);
    });

    const CellCloud cloud(tree, depth);

    CAPTURE(depth);
    REQUIRE(cloud.cells().size() == expected.size());
    for (const DrawnCell& cell : cloud.cells()) {
      const auto found = expected.find({cell.centre[0], cell.centre[1], cell.centre[2]});
      REQUIRE(found != expected.end());
      REQUIRE(cell.depth == found->second.cell.depth);
      REQUIRE(cell.log_odds == found->second.state.log_odds);
      REQUIRE((cell.coloured != 0) == found->second.state.colour.exists());
      if (cell.coloured != 0) REQUIRE(cell.rgb == found->second.state.colour.rgb());
    }
  }
}

TEST_CASE("a cloud's cells lie by depth", "[cloud]") {
  auto rng = test::engine();
  const CellCloud cloud(random_tree(rng), kDepth);
  std::size_t sum = 0;
  for (int depth = 0; depth <= kDepth; ++depth) {
    for (const DrawnCell& cell : cloud.cells_of_depth(depth)) REQUIRE(cell.depth == depth);
    sum += cloud.cells_of_depth(depth).size();
  }
  REQUIRE(sum == cloud.cells().size());
  REQUIRE(cloud.cells_of_depth(kDepth).data() + cloud.cells_of_depth(kDepth).size() ==
          cloud.cells().data() + cloud.cells().size());
}

TEST_CASE("a full tile is its surface, an empty one nothing", "[cloud]") {
  REQUIRE(CellCloud(TileTree(), kDepth).cells().empty());
  TileTree full;
  full.set({0, 0}, {3000, {}});
  REQUIRE(CellCloud(full, kDepth).cells().size() == 1);
  REQUIRE(CellCloud(full, kDepth).cells()[0].centre == std::array<std::int16_t, 3>{128, 128, 128});
  full.set({kDepth, 0}, {3001, {}});  // No longer one leaf.
  REQUIRE(CellCloud(full, 4).cells().size() < 4096);
}

}  // namespace
}  // namespace voxatlas
