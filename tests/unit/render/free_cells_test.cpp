#include "render/free_cells.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "grid/grid.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Free and occupied cells of all sizes.
TileTree random_tile(std::mt19937_64& rng) {
  TileTree tile;
  std::uniform_int_distribution<std::uint32_t> place(0, 127);
  for (int i = 0; i < 300; ++i) {
    const auto log_odds = static_cast<LogOdds>(i % 3 == 0 ? 500 : -500);
    tile.set(
        CellKey::of_voxel({place(rng), place(rng), place(rng)}, i < 20 ? 2 + i % 4 : 5 + i % 3),
        {log_odds, {}});
  }
  return tile;
}

/// The oracle: free where some voxel of the cell is known and none is occupied.
bool free_by_voxels(const TileTree& tile, int depth, const Eigen::Vector3i& at) {
  const std::uint32_t size = 1u << (kDepth - depth);
  bool known = false;
  for (std::uint32_t i = 0; i < size * size * size; ++i) {
    const Index3 voxel{static_cast<std::uint32_t>(at.x()) * size + i % size,
                       static_cast<std::uint32_t>(at.y()) * size + i / size % size,
                       static_cast<std::uint32_t>(at.z()) * size + i / size / size};
    const auto state = tile.voxel(voxel);
    if (!state) continue;
    if (is_occupied(state->log_odds)) return false;
    known = true;
  }
  return known;
}

TEST_CASE("free cells are those that know something and hold nothing", "[free][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int depth = 0; depth <= 5; ++depth) {
    const TileTree tile = random_tile(rng);
    const FreeCells cells(tile, depth);
    REQUIRE(cells.depth() == depth);
    std::size_t count = 0;
    const int edge = cells.edge();
    for (int i = 0; i < edge * edge * edge; ++i) {
      const Eigen::Vector3i at(i % edge, i / edge % edge, i / edge / edge);
      REQUIRE(cells.holds(at) == free_by_voxels(tile, depth, at));
      count += cells.holds(at);
    }
    REQUIRE(cells.count() == count);
  }
}

TEST_CASE("free space is bounded where it ends, across tiles too", "[free][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Grid grid = Grid::standard();
  const VoxelIndex corner = Grid::min_voxel(grid.tile_at({4.1e6, 8e5, 4.7e6}).value());
  constexpr int kCells = 4, kEdge = 1 << kCells;
  std::vector<FreeCells> cells;
  std::vector<TileKey> keys;
  for (int i = 0; i < 8; ++i) {
    cells.emplace_back(random_tile(rng), kCells);
    keys.push_back(grid.tile_of(corner + kTileVoxels * VoxelIndex(i & 1, i >> 1 & 1, i >> 2)));
  }
  std::vector<PlacedFree> placed;
  for (std::size_t i = 0; i < 8; ++i) placed.push_back({keys[i], &cells[i]});
  // The oracle: all eight as one array.
  const auto holds = [&](const Eigen::Vector3i& at) {
    if ((at.array() < 0).any() || (at.array() >= 2 * kEdge).any()) return false;
    const Eigen::Vector3i tile = at / kEdge;
    return cells[static_cast<std::size_t>(tile.x() + 2 * tile.y() + 4 * tile.z())].holds(
        at - kEdge * tile);
  };
  using Face = std::tuple<int, int, int, int, bool>;
  std::set<Face> expected, found;
  for (int i = 0; i < 8 * kEdge * kEdge * kEdge; ++i) {
    const Eigen::Vector3i at(i % (2 * kEdge), i / (2 * kEdge) % (2 * kEdge),
                             i / (4 * kEdge * kEdge));
    if (!holds(at)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        if (!holds(at + (upper ? 1 : -1) * Eigen::Vector3i::Unit(axis))) {
          expected.emplace(at.x(), at.y(), at.z(), axis, upper);
        }
      }
    }
  }
  const auto faces = bounding_faces(placed);
  REQUIRE(faces.size() == 8);
  for (int i = 0; i < 8; ++i) {
    for (const FreeFace& face : faces[static_cast<std::size_t>(i)]) {
      const Eigen::Vector3i at = face.cell + kEdge * Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2);
      REQUIRE(found.emplace(at.x(), at.y(), at.z(), face.axis, face.upper).second);
    }
  }
  REQUIRE(found == expected);
}

TEST_CASE("unknown space is not free", "[free]") {
  TileTree tile;
  REQUIRE(FreeCells(tile, 3).count() == 0);
  tile.set({7, 0}, {-1, {}});
  REQUIRE(FreeCells(tile, 7).count() == 1);
  REQUIRE(FreeCells(tile, 0).count() == 1);
  tile.set({7, 1}, {0, {}});  // As likely as not counts as occupied.
  REQUIRE(FreeCells(tile, 7).count() == 1);
  REQUIRE(FreeCells(tile, 6).count() == 0);
  REQUIRE(bounding_faces({}).empty());
}

}  // namespace
}  // namespace voxatlas
