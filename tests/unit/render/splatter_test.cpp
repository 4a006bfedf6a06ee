#include "render/splatter.hpp"

#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "forest.hpp"
#include "scene.hpp"
#include "support/engine.hpp"
#include "support/ray_caster.hpp"
#include "support/slow_build.hpp"

namespace voxatlas {
namespace {

constexpr double kDepthTolerance = 1e-3;
constexpr double kEdgeTolerance = 1e-4;

/// Eight tiles around a corner of the grid: ground and walls that are tilted in it, single voxels,
/// cells of all sizes, free space, all across the borders between the tiles.
std::map<TileKey, TileTree> mixed_scene(std::mt19937_64& rng) {
  test::Scene scene;
  const auto& grid = scene.grid();
  const VoxelIndex middle = Grid::min_voxel(grid.tile_at(scene.frame().to_ecef({0, 0, 0})).value());
  std::map<TileKey, TileTree> tiles;
  const auto tile_at = [&](const VoxelIndex& voxel) -> TileTree& {
    return tiles[grid.tile_of(voxel)];
  };
  std::uniform_int_distribution<int> near_corner(-128, 127), few(-20, 19), any_depth(3, 7);
  const auto random_voxel = [&](auto& spread) {
    return VoxelIndex(middle + VoxelIndex(spread(rng), spread(rng), spread(rng)));
  };
  for (int i = 0; i < 60; ++i) {  // Cells of many sizes, some of them free.
    const VoxelIndex voxel = random_voxel(near_corner);
    const int depth = any_depth(rng);
    tile_at(voxel).set(CellKey::of_voxel(Grid::in_tile(voxel), depth),
                       {static_cast<LogOdds>(i % 3 == 0 ? -2000 : 2000 + i), {}});
  }
  const auto occupy = [&](const VoxelIndex& voxel) {
    tile_at(voxel).set(CellKey::of_voxel(Grid::in_tile(voxel), kDepth), {3000, {}});
  };
  for (int i = 0; i < 2000; ++i) occupy(random_voxel(near_corner));
  for (int i = 0; i < 800; ++i) occupy(random_voxel(few));
  const Eigen::Vector3d corner = grid.min_corner(middle);
  const auto plane = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v, double offset) {
    const Eigen::Vector3d normal = u.cross(v).normalized();
    for (double a = -9; a < 9; a += 0.05) {
      for (double b = -9; b < 9; b += 0.05) {
        const auto voxel = grid.voxel_unchecked(corner + a * u + b * v + offset * normal);
        if (((voxel - middle).array() >= -128).all() && ((voxel - middle).array() < 128).all()) {
          occupy(voxel);
        }
      }
    }
  };
  const Eigen::Vector3d east = scene.frame().to_ecef({1, 0, 0}) - scene.frame().to_ecef({0, 0, 0});
  const Eigen::Vector3d north = scene.frame().to_ecef({0, 1, 0}) - scene.frame().to_ecef({0, 0, 0});
  plane(east, north, -3);
  plane(east, east.cross(north), 4);
  plane(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 6.4);
  return tiles;
}

/// Anywhere in and around the scene, half of them on borders of cells or tiles, some along an axis.
Camera random_camera(std::mt19937_64& rng, const Grid& grid, const VoxelIndex& middle, int width,
                     int height, bool orthographic = false) {
  std::uniform_real_distribution<double> unit(0, 1), offset(-16, 16), turn(-1, 1);
  Lens lens = orthographic ? Lens::of_map(std::pow(10, 0.5 + 2 * unit(rng)), width, height)
                           : Lens::of_view(20 + 90 * unit(rng), width, height);
  lens.near_range = unit(rng) < 0.5 ? 0.3 : std::pow(10, -3 + 3 * unit(rng));
  // Were a map's near plane a face of cells, all of its pixels would be at an edge.
  if (orthographic) lens.near_range += 0.01 + 0.03 * unit(rng);
  lens.far_range = unit(rng) < 0.8 ? 200 : lens.near_range + 12 * unit(rng) + 0.01;
  Eigen::Vector3d eye =
      grid.min_corner(middle) + Eigen::Vector3d(offset(rng), offset(rng), offset(rng));
  if (unit(rng) < 0.3) {
    eye = grid.min_corner(middle) + Eigen::Vector3d(turn(rng), turn(rng), turn(rng));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (unit(rng) < 0.25) eye[axis] = std::round(eye[axis] * 10) / 10.0;
    if (unit(rng) < 0.05) eye[axis] = grid.min_corner(middle)[axis];
  }
  Eigen::Quaterniond q(turn(rng), turn(rng), turn(rng), turn(rng));
  if (unit(rng) < 0.1) q = Eigen::Quaterniond(1, 0, 0, unit(rng) < 0.5 ? 0 : 1);
  return Camera::create(eye, q.normalized(), lens).value();
}

struct Tally {
  std::size_t pixels = 0, shown = 0, at_edges = 0, wrong = 0, holes = 0;
};

/// True where some ray right beside this one shows just what the picture says.
bool shown_beside(const test::RayCaster& caster, const test::RayCaster::View& view, double x,
                  double y, const std::optional<test::RayCaster::Sight>& seen, double near_z) {
  const double pixel = near_z * view.ray_x.norm() + view.start_x.norm() / 10;  // Metres there.
  const double step = 3 * kEdgeTolerance / pixel;
  for (int i = 0; i < 16; ++i) {
    const double angle = i * 0.3927;
    const auto beside = caster.cast(view, x + step * std::cos(angle), y + step * std::sin(angle));
    if (beside.has_value() != seen.has_value()) continue;
    if (!seen || (beside->tile == seen->tile && beside->cell == seen->cell)) return true;
  }
  return false;
}

void compare(const CellImage& image, const test::Forest& forest, const test::RayCaster& caster,
             const Camera& camera, const Grid& grid, Tally& tally) {
  const test::RayCaster::View view(camera, grid);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t at = image.index(x, y);
      const auto expected = caster.cast(view, x + 0.5, y + 0.5);
      std::optional<test::RayCaster::Sight> seen;
      if (image.cell[at] != CellImage::kNone) {
        const auto& [tile, cell] = forest.cell(image.cell[at]);
        seen = {tile, cell, image.z[at]};
      }
      ++tally.pixels;
      tally.shown += seen.has_value();
      if (seen.has_value() == expected.has_value() &&
          (!seen || (seen->tile == expected->tile && seen->cell == expected->cell &&
                     std::abs(seen->z - expected->z) <= kDepthTolerance))) {
        continue;
      }
      double edge = 1, nearest = 1e9;
      for (const auto& sight : {seen, expected}) {
        if (!sight) continue;
        edge =
            std::min(edge, caster.edge_distance(view, x + 0.5, y + 0.5, sight->tile, sight->cell));
        nearest = std::min(nearest, sight->z);
      }
      if (edge > kEdgeTolerance) {
        if (++tally.wrong <= 5) {
          UNSCOPED_INFO("pixel " << x << " " << y << " z " << (seen ? seen->z : -1) << " expected "
                                 << (expected ? expected->z : -1) << ", edge " << edge
                                 << " m, near " << camera.lens().near_range);
        }
      } else if (!shown_beside(caster, view, x + 0.5, y + 0.5, seen, nearest)) {
        ++tally.holes;
      } else {
        ++tally.at_edges;
      }
    }
  }
}

int cameras(int count) { return test::kSlowBuild ? count / 20 + 1 : count; }

TEST_CASE("each pixel shows the cell and the depth that a ray finds", "[splat][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Grid grid = Grid::standard();
  const auto tiles = mixed_scene(rng);
  const VoxelIndex middle = Grid::min_voxel(tiles.rbegin()->first);
  REQUIRE(tiles.size() == 8);
  const test::Forest forest(tiles);
  const auto [depth, count, orthographic] = GENERATE(table<int, int, bool>({{7, 1000, false},
                                                                            {6, 20, false},
                                                                            {5, 20, false},
                                                                            {3, 20, false},
                                                                            {0, 20, false},
                                                                            {7, 200, true},
                                                                            {4, 20, true}}));
  const test::RayCaster caster(grid, tiles, depth);
  Splatter splatter(2);
  SplatOptions options;
  options.max_depth = depth;
  Tally tally;
  CellImage image;
  for (int i = 0; i < cameras(count); ++i) {
    const Camera camera = random_camera(rng, grid, middle, 160, 120, orthographic);
    REQUIRE(splatter.draw(camera, grid, forest.placed(), options, image).has_value());
    compare(image, forest, caster, camera, grid, tally);
  }
  CAPTURE(depth, orthographic, tally.pixels, tally.shown, tally.at_edges, tally.wrong, tally.holes);
  CHECK(tally.wrong == 0);
  CHECK(tally.holes == 0);
  CHECK(tally.at_edges * 10'000 < tally.pixels);
  CHECK(tally.shown > tally.pixels / 4);
}

TEST_CASE("ten large pictures show what rays find, pixel by pixel", "[.long][splat][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Grid grid = Grid::standard();
  const auto tiles = mixed_scene(rng);
  const VoxelIndex middle = Grid::min_voxel(tiles.rbegin()->first);
  const test::Forest forest(tiles);
  const test::RayCaster caster(grid, tiles, kDepth);
  Splatter splatter(2);
  Tally tally;
  CellImage image;
  for (int i = 0; i < 10; ++i) {
    const Camera camera = random_camera(rng, grid, middle, 1280, 720, i % 5 == 4);
    REQUIRE(splatter.draw(camera, grid, forest.placed(), {}, image).has_value());
    compare(image, forest, caster, camera, grid, tally);
  }
  CAPTURE(tally.pixels, tally.shown, tally.at_edges, tally.wrong, tally.holes);
  CHECK(tally.pixels == 10 * 1280 * 720);
  CHECK(tally.wrong == 0);
  CHECK(tally.holes == 0);
  CHECK(tally.at_edges * 10'000 < tally.pixels);
  CHECK(tally.shown > tally.pixels / 4);
}

TEST_CASE("instructions, threads, culling and the trees' order change no pixel", "[splat]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Grid grid = Grid::standard();
  const auto tiles = mixed_scene(rng);
  const VoxelIndex middle = Grid::min_voxel(tiles.rbegin()->first);
  const test::Forest forest(tiles);
  std::vector<PlacedTree> reversed(forest.placed().rbegin(), forest.placed().rend());
  const TreeNumbers numbers(forest.placed()), reversed_numbers(reversed);
  Splatter alone(1), many(5);
  const std::int64_t all_targets = hwy::SupportedTargets();
  int targets = 0;
  for (int i = 0; i < cameras(40); ++i) {
    const Camera camera = random_camera(rng, grid, middle, 203, 117, i % 4 == 3);
    CellImage expected, image;
    REQUIRE(alone.draw(camera, grid, forest.placed(), {}, expected).has_value());
    for (std::int64_t left = all_targets; left != 0; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      hwy::GetChosenTarget().DeInit();
      REQUIRE(alone.draw(camera, grid, forest.placed(), {}, image).has_value());
      REQUIRE(image.cell == expected.cell);
      REQUIRE(image.z == expected.z);
      ++targets;
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
    REQUIRE(many.draw(camera, grid, forest.placed(), {kDepth, 0, false}, image).has_value());
    REQUIRE(image.cell == expected.cell);
    REQUIRE(image.z == expected.z);
    REQUIRE(many.draw(camera, grid, reversed, {}, image).has_value());
    REQUIRE(image.z == expected.z);
    for (std::size_t at = 0; at < image.cell.size(); ++at) {
      if (image.cell[at] == CellImage::kNone || image.cell[at] == expected.cell[at]) continue;
      const auto a = numbers.find(expected.cell[at]), b = reversed_numbers.find(image.cell[at]);
      REQUIRE(numbers.tree(a).key == reversed_numbers.tree(b).key);
      REQUIRE(a.node == b.node);
    }
  }
  REQUIRE(targets >= 2 * cameras(40));
}

TEST_CASE("a threshold of pixels draws far tiles with larger cells", "[splat]") {
  auto rng = test::engine();
  const Grid grid = Grid::standard();
  const auto tiles = mixed_scene(rng);
  const VoxelIndex middle = Grid::min_voxel(tiles.rbegin()->first);
  const test::Forest forest(tiles);
  const TreeNumbers numbers(forest.placed());
  Splatter splatter(1);
  const Eigen::Vector3d target = grid.min_corner(middle);
  CellImage image;
  for (const double range : {1.0, 30.0, 60.0, 120.0, 240.0}) {
    const Eigen::Vector3d eye = target + range * Eigen::Vector3d(0.6, 0.64, 0.48);
    const Camera camera =
        Camera::look_at(eye, target, Eigen::Vector3d::UnitZ(), Lens::of_view(40, 160, 120)).value();
    REQUIRE(splatter.draw(camera, grid, forest.placed(), {kDepth, 4.0, true}, image).has_value());
    int deepest = 0;
    for (std::size_t at = 0; at < image.cell.size(); ++at) {
      if (image.cell[at] == CellImage::kNone) continue;
      const auto found = numbers.find(image.cell[at]);
      const int depth = numbers.depth(found);
      deepest = std::max(deepest, depth);
      // No cell that has children below it is wider than the threshold.
      const bool cut =
          depth < kDepth && numbers.tree(found).tree->children(found.node).octants != 0;
      if (cut) REQUIRE(camera.lens().fx * grid.cell_length(depth) / image.z[at] <= 4.001);
    }
    // The deepest cells drawn are no finer than they need be.
    const double nearest = std::max(range - 23, 0.3);
    const double finer = camera.lens().fx * grid.cell_length(deepest - 1) / nearest;
    CAPTURE(range, deepest);
    REQUIRE((deepest == 0 || finer > 4));
  }
}

TEST_CASE("the splatter refuses what it cannot draw and draws nothing of nothing", "[splat]") {
  const test::Scene scene;
  const Camera camera = scene.camera({0, 0, 2}, {0, 9, 2}, Lens::of_view(50, 7, 5)).value();
  Splatter splatter(1);
  CellImage image;
  for (const int depth : {-1, 8}) {
    REQUIRE_FALSE(splatter.draw(camera, scene.grid(), {}, {depth, 0, true}, image).has_value());
  }
  for (const double threshold : {-1.0, std::nan("")}) {
    const auto drawn = splatter.draw(camera, scene.grid(), {}, {7, threshold, true}, image);
    REQUIRE_FALSE(drawn.has_value());
    REQUIRE(drawn.error().code == ErrorCode::kOutOfRange);
  }
  const RenderTree nothing{TileTree{}};
  const PlacedTree placed{scene.grid().tile_at(camera.position()).value(), &nothing};
  REQUIRE(splatter.draw(camera, scene.grid(), {&placed, 1}, {}, image).has_value());
  REQUIRE(image.cell == std::vector<std::uint32_t>(35, CellImage::kNone));
  REQUIRE(image.z == std::vector<float>(35, CellImage::kNowhere));
}

}  // namespace
}  // namespace voxatlas
