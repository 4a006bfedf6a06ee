#include "render/render_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <random>

#include "grid/grid.hpp"
#include "render/tree_numbers.hpp"
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

/// All occupied and alike but for a few voxels: leaves of all sizes, colours equal or not.
TileTree almost_full_tile(std::mt19937_64& rng) {
  TileTree tile;
  CellState state{2000, {}};
  state.colour.add({200, 100, 50});
  tile.set({0, 0}, state);
  std::uniform_int_distribution<std::uint32_t> place(0, 127);
  const auto somewhere = [&] {
    return CellKey::of_voxel({place(rng), place(rng), place(rng)}, kDepth);
  };
  tile.set(somewhere(), {2001, state.colour});
  tile.set(somewhere(), {2000, {}});
  tile.set(somewhere(), {-5, {}});
  state.colour.add({200, 100, 50});  // The same mean of more scans: another state.
  tile.set(somewhere(), state);
  tile.erase(somewhere());
  return tile;
}

/// Walks a tree from its root by its children alone.
void walk(const RenderTree& tree, std::uint32_t node, CellKey cell,
          std::map<CellKey, std::uint32_t>& found) {
  REQUIRE(found.emplace(cell, node).second);
  if (cell.depth == tree.depth()) return;
  const TreeChildren children = tree.children(node);
  std::uint32_t child = children.first;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if ((children.octants & 1u << octant) != 0) walk(tree, child++, cell.child(octant), found);
  }
}

TEST_CASE("a render tree has the tile's occupied cells at every depth", "[render_tree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 8; ++round) {
    const TileTree tile = round == 7 ? almost_full_tile(rng) : random_tile(rng);
    const int max_depth = round < 4 ? kDepth : round;
    const RenderTree tree(tile, 17, max_depth);
    REQUIRE(tree.version() == 17);
    REQUIRE(tree.max_depth() == max_depth);
    std::map<CellKey, std::uint32_t> found;
    walk(tree, 0, {0, 0}, found);
    REQUIRE(found.size() == tree.node_count());
    for (int depth = 0; depth <= max_depth; ++depth) {
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
    REQUIRE(tree.cell_count(kDepth) == tree.cell_count(max_depth));
  }
}

/// Planes in all directions, single voxels and coarser leaves over eight tiles: whether a voxel of
/// 0 .. 255 is occupied.
class Terrain {
 public:
  explicit Terrain(std::mt19937_64& rng) {
    std::normal_distribution<double> side;
    for (auto& plane : planes_) {
      plane.head<3>() = Eigen::Vector3d(side(rng), side(rng), side(rng)).normalized();
      plane[3] = 20 * side(rng);
    }
  }
  /// The tile whose lower corner is this voxel.
  TileTree tile(const Eigen::Vector3i& corner) const {
    TileTree tile;
    for (std::uint32_t z = 0; z < 128; ++z) {
      for (std::uint32_t y = 0; y < 128; ++y) {
        for (std::uint32_t x = 0; x < 128; ++x) {
          const Eigen::Vector3i at =
              corner +
              Eigen::Vector3i(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
          if (occupied(at)) tile.set(CellKey::of_voxel({x, y, z}, kDepth), {3000, {}});
        }
      }
    }
    return tile;
  }

 private:
  bool occupied(const Eigen::Vector3i& at) const {
    const Eigen::Vector3d p = at.cast<double>() - Eigen::Vector3d::Constant(127.5);
    if ((p.cwiseAbs().array() < 9).all()) return true;  // Solid: leaves above depth 7.
    return std::any_of(planes_.begin(), planes_.end(), [&](const Eigen::Vector4d& plane) {
      return std::abs(plane.head<3>().dot(p) - plane[3]) < 0.6;
    });
  }

  std::array<Eigen::Vector4d, 4> planes_;
};

TEST_CASE("across a tile's faces normals are those of one larger tile", "[render_tree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Terrain terrain(rng);
  std::vector<RenderTree> trees;
  for (int i = 0; i < 8; ++i) {
    trees.emplace_back(terrain.tile(128 * Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2)), 5);
  }
  // The oracle: a tile half a tile along, whose middle is where the eight meet.
  const Eigen::Vector3i half = Eigen::Vector3i::Constant(64);
  const RenderTree shifted(terrain.tile(half));
  using Place = std::array<int, 4>;  // Depth; place in cells of it, over all tiles.
  const auto place_of = [](CellKey cell, const Eigen::Vector3i& corner) {
    const Index3 min = cell.min_voxel();
    const int shift = kDepth - cell.depth;
    Place place{cell.depth, 0, 0, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis + 1] =
          (static_cast<int>(min[axis]) + corner[static_cast<Eigen::Index>(axis)]) >> shift;
    }
    return place;
  };
  std::map<Place, Eigen::Vector3f> expected;
  for (std::uint32_t node = 0; node < shifted.node_count(); ++node) {
    const Place place = place_of(shifted.key_of(node), half);
    const int low = 64 >> (kDepth - place[0]), high = 192 >> (kDepth - place[0]);
    const bool inside = place[0] >= 3 && std::all_of(place.begin() + 1, place.end(), [&](int at) {
                          return at >= low + 2 && at < high - 2;
                        });
    if (inside) expected[place] = shifted.paint(node).normal();
  }
  std::size_t compared = 0, changed = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i own(i & 1, i >> 1 & 1, i >> 2);
    const RenderTree& alone = trees[static_cast<std::size_t>(i)];
    TreesAround around(alone);
    for (int j = 0; j < 8; ++j) {
      around.set(Eigen::Vector3i(j & 1, j >> 1 & 1, j >> 2) - own,
                 &trees[static_cast<std::size_t>(j)]);
    }
    const RenderTree tree = alone.with_borders(around);
    REQUIRE(tree.version() == 5);
    REQUIRE(tree.node_count() == alone.node_count());
    for (std::uint32_t node = 0; node < tree.node_count(); ++node) {
      const auto found = expected.find(place_of(tree.key_of(node), 128 * own));
      if (found == expected.end()) continue;
      ++compared;
      changed += tree.paint(node).normal() != alone.paint(node).normal();
      REQUIRE(tree.paint(node).normal() == found->second);
    }
  }
  CAPTURE(compared, changed);
  REQUIRE(compared == expected.size());
  REQUIRE(compared > 10'000);
  REQUIRE(changed > 200);
}

/// Cells that change anyhow, some of them whole branches.
void change_some(TileTree& tile, std::mt19937_64& rng) {
  std::uniform_int_distribution<std::uint32_t> place(0, 127);
  std::uniform_int_distribution<int> count(0, 6), log_odds(-3000, 3000), what(0, 3);
  for (int i = count(rng); i > 0; --i) {
    const auto cell = CellKey::of_voxel({place(rng), place(rng), place(rng)},
                                        what(rng) == 0 ? 4 + i % 3 : kDepth);
    if (what(rng) == 0) {
      tile.erase(cell);
    } else {
      tile.set(cell, {static_cast<LogOdds>(log_odds(rng)), {}});
    }
  }
}

TEST_CASE("of a tile that has changed a tree is the same, whatever it was made of before",
          "[render_tree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const RenderTree neighbour(Terrain(rng).tile({0, 0, 0}));
  for (int round = 0; round < 12; ++round) {
    TileTree tile = round == 0   ? almost_full_tile(rng)
                    : round == 1 ? TileTree()
                    : round < 6  ? random_tile(rng)
                                 : Terrain(rng).tile({128, 0, 128});
    auto before = std::make_unique<RenderTree>(tile, 1);
    for (std::uint64_t version = 2; version < 6; ++version) {
      TreesAround around(*before);
      around.set({1, 0, 0}, &neighbour);
      const RenderTree bordered = before->with_borders(around);
      change_some(tile, rng);
      if (version == 5) tile = round % 2 == 0 ? TileTree() : random_tile(rng);
      auto after = std::make_unique<RenderTree>(tile, version, kDepth, &bordered);
      const RenderTree oracle(tile, version);
      REQUIRE(after->version() == version);
      REQUIRE(after->node_count() == oracle.node_count());
      const auto same = [&](const RenderTree& one, const RenderTree& other, int margin) {
        for (std::uint32_t node = 0; node < one.node_count(); ++node) {
          const CellKey key = one.key_of(node);
          REQUIRE(key == other.key_of(node));
          REQUIRE(one.paint(node).log_odds() == other.paint(node).log_odds());
          const Index3 at = key.min_voxel();
          const auto inside = [&](std::uint32_t voxel) {
            const int cell = static_cast<int>(voxel >> (kDepth - key.depth));
            return cell >= margin && cell < (1 << key.depth) - margin;
          };
          if (!inside(at[0]) || !inside(at[1]) || !inside(at[2])) continue;
          REQUIRE(one.paint(node).normal() == other.paint(node).normal());
        }
      };
      same(*after, oracle, 2);
      if (!after->empty()) {
        const TreesAround after_alone(*after), oracle_alone(oracle);
        same(after->with_borders(after_alone), oracle.with_borders(oracle_alone), 0);
      }
      before = std::move(after);
    }
  }
}

TEST_CASE("borders of nothing change nothing, and coarse neighbours fill nothing",
          "[render_tree]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const RenderTree tree(random_tile(rng)), coarse(random_tile(rng), 0, 3), none;
  const auto normals = [](const RenderTree& of) {
    std::vector<Eigen::Vector3f> all;
    for (std::uint32_t node = 0; node < of.node_count(); ++node) {
      all.push_back(of.paint(node).normal());
    }
    return all;
  };
  TreesAround around(tree);
  around.set({1, 0, 0}, &none);
  REQUIRE(normals(tree.with_borders(around)) == normals(tree));
  around.set({0, 0, -1}, &coarse);
  const RenderTree beside = tree.with_borders(around);
  for (std::uint32_t node = 0; node < tree.node_count(); ++node) {
    if (tree.depth_of(node) > 3) {
      REQUIRE(beside.paint(node).normal() == tree.paint(node).normal());
    }
  }
  REQUIRE(none.with_borders(TreesAround(none)).empty());
}

TEST_CASE("a paint keeps a normal to two degrees", "[render_tree]") {
  auto rng = test::engine();
  std::normal_distribution<float> side;
  CellPaint paint({100, {}});
  REQUIRE(paint.normal().isZero());
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Vector3f normal(side(rng), side(rng), side(rng));
    for (int axis = 0; axis < 3; ++axis) {
      if (i % 5 == axis) normal[axis] = 0;
    }
    normal.normalize();
    paint.set_normal(normal);
    const Eigen::Vector3f kept = paint.normal();
    CAPTURE(normal.transpose(), kept.transpose());
    REQUIRE(kept.cross(normal).norm() < 0.035f);
    REQUIRE(kept.dot(normal) > 0);
  }
  paint.set_normal(Eigen::Vector3f::Zero());
  REQUIRE(paint.normal().isZero());
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
