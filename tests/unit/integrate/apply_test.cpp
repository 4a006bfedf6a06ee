// Scans through the integrator and TileTree::apply, against sorted crossings into dense arrays.
#include <catch2/catch.hpp>
#include <map>

#include "integrate/integrator.hpp"
#include "octree/tile_tree.hpp"
#include "support/dense_tile.hpp"
#include "support/engine.hpp"
#include "unit/integrate/scan_oracle.hpp"

namespace voxatlas {
namespace {

using DenseMap = std::map<TileKey, test::DenseTile>;

/// The tile of a cell given over the whole grid, and the cell in it.
std::pair<TileKey, CellKey> placed(const test::GlobalCell& cell, int depth, const Grid& grid) {
  const int up = kDepth - depth;
  const VoxelIndex voxel(static_cast<int>(cell[0] << up), static_cast<int>(cell[1] << up),
                         static_cast<int>(cell[2] << up));
  return {grid.tile_of(voxel), CellKey::of_voxel(Grid::in_tile(voxel), depth)};
}

void apply(const test::ScanCells& cells, const Grid& grid, const SensorModel& model,
           DenseMap& dense) {
  for (const auto& miss : cells.misses) {
    const auto [tile, cell] = placed(miss, cells.miss_depth, grid);
    dense[tile].miss(cell, model);
  }
  for (const auto& hit : cells.hits) {
    const auto [tile, cell] = placed(hit, cells.hit_depth, grid);
    const auto colour = cells.colours.find(hit);
    std::optional<Rgb> seen;
    if (colour != cells.colours.end()) {
      const auto& [r, g, b] = colour->second;
      seen = Rgb{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                 static_cast<std::uint8_t>(b)};
    }
    dense[tile].hit(cell, model, seen);
  }
}

TEST_CASE("scans of all kinds in sequence leave the tiles that dense arrays are left as",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto grid = Grid::standard();
  const auto model = SensorModel::standard();
  const double tile = grid.tile_length();
  const Eigen::Vector3d corner = tile * Eigen::Vector3d(324'000, 0, -370'000);
  std::map<TileKey, TileTree> tiles;
  DenseMap dense;
  for (int i = 0; i < 24; ++i) {
    const IntegrationParameters parameters{static_cast<int>(rng() % 9) - 1,
                                           static_cast<int>(rng() % 8), i % 3 == 0 ? 0.7 : 0.0,
                                           i % 2 == 0 ? 9.0 : 120.0, rng() % 2 == 0};
    auto scan = test::ScanMaker{corner, 0.6 * tile, 10, 60, i % 3 != 0}(rng);
    scan.sigma = rng() % 3 == 0 ? tile / (4 << rng() % 8) : 0.02;
    const auto delta = Integrator(grid, parameters).integrate(scan);
    REQUIRE(delta.has_value());
    for (const auto& [key, change] : delta->tiles) tiles[key].apply(change, model);
    apply(test::cells_by_sorting(scan, parameters, 10), grid, model, dense);
  }
  REQUIRE(tiles.size() == dense.size());
  REQUIRE(tiles.size() >= 8);
  for (const auto& [key, tree] : tiles) {
    CAPTURE(key.morton());
    REQUIRE(difference(tree, dense.at(key)) == "");
  }
}

}  // namespace
}  // namespace voxatlas
