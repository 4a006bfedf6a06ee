#include "grid/grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/engine.hpp"
#include "unit/grid/morton_bits.hpp"

namespace voxatlas {
namespace {

using Cells = std::array<std::int64_t, 3>;

/// Oracle: the tile of a point in whole cells from the Earth's centre, no floating point, no shift.
Index3 tile_by_cells(const Cells& p_cells, int k) {
  Index3 index{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    index[axis] = static_cast<std::uint32_t>((p_cells[axis] + 6'400'000 * std::int64_t{k}) / 128);
  }
  return index;
}

VoxelIndex voxel_by_cells(const Cells& p_cells, int k) {
  VoxelIndex voxel;
  for (int axis = 0; axis < 3; ++axis) {
    voxel[axis] =
        static_cast<int>(p_cells[static_cast<std::size_t>(axis)] + 6'400'000 * std::int64_t{k});
  }
  return voxel;
}

TEST_CASE("a Grid agrees with integer arithmetic on every border, for every k", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int k = 1; k <= 20; ++k) {
    const auto grid = Grid::create(k);
    REQUIRE(grid.has_value());
    const std::int64_t half = 6'400'000 * std::int64_t{k};
    std::uniform_int_distribution<std::int64_t> cell(-half, half - 1);
    for (int i = 0; i < 20'000; ++i) {
      const bool on_a_face = i % 2 == 0;  // Of tiles; every point lies between two voxels.
      Cells p_cells{};
      Eigen::Vector3d p_ecef;
      for (int axis = 0; axis < 3; ++axis) {
        std::int64_t n = cell(rng);
        if (on_a_face) n -= ((n % 128) + 128) % 128;
        p_cells[static_cast<std::size_t>(axis)] = n;
        p_ecef[axis] = static_cast<double>(n) / k;
      }
      CAPTURE(k, p_cells);
      const VoxelIndex voxel = voxel_by_cells(p_cells, k);
      REQUIRE(grid->voxel_at(p_ecef) == voxel);
      REQUIRE(grid->voxel_unchecked(p_ecef) == voxel);
      REQUIRE(grid->to_voxels(p_ecef) == voxel.cast<double>());
      REQUIRE(grid->min_corner(voxel) == p_ecef);
      const auto tile = grid->tile_at(p_ecef);
      REQUIRE(tile.has_value());
      REQUIRE(tile->index() == tile_by_cells(p_cells, k));
      REQUIRE(tile->morton() == test::morton_by_bits(tile->index()));
      REQUIRE(grid->tile_at(grid->min_corner(*tile)) == *tile);
      REQUIRE(grid->tile_from_morton(tile->morton()) == *tile);
    }
  }
}

TEST_CASE("a Grid places points inside voxels, and just below borders, as integers do",
          "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int k = 1; k <= 20; ++k) {
    const auto grid = Grid::create(k);
    const std::int64_t half = 6'400'000 * std::int64_t{k};
    std::uniform_int_distribution<std::int64_t> cell(-half, half - 1);
    std::uniform_int_distribution<std::int64_t> thousandth(1, 999'999);
    for (int i = 0; i < 5'000; ++i) {
      Cells p_cells{};
      Eigen::Vector3d p_ecef;
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t n = cell(rng);
        const std::int64_t part = i % 2 == 0 ? 999'999 : thousandth(rng);  // Of a millionth cell.
        p_cells[static_cast<std::size_t>(axis)] = n;
        p_ecef[axis] = static_cast<double>(n * 1'000'000 + part) / (1e6 * k);
      }
      CAPTURE(k, p_cells);
      const VoxelIndex voxel = voxel_by_cells(p_cells, k);
      REQUIRE(grid->voxel_at(p_ecef) == voxel);
      REQUIRE(grid->to_voxels(p_ecef).array().floor().matrix() == voxel.cast<double>());
      const Eigen::Vector3d exact = p_ecef * k + Eigen::Vector3d::Constant(6.4e6 * k);
      REQUIRE((grid->to_voxels(p_ecef) - exact).cwiseAbs().maxCoeff() < 1e-7);
    }
  }
}

TEST_CASE("to_voxels and voxel_at never disagree, not on the doubles beside a border", "[grid]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const double inf = std::numeric_limits<double>::infinity();
  for (int k = 1; k <= 20; ++k) {
    const auto grid = Grid::create(k);
    const int half = grid->half_voxels();
    std::uniform_int_distribution<int> cell(-half + 1, half - 1);
    for (int i = 0; i < 20'000; ++i) {
      const int n = i % 4 == 0 ? i / 4 % 64 - 32 : cell(rng);  // Near 0 doubles are dense.
      const double border = static_cast<double>(n) / k;
      for (const double x : {std::nextafter(border, -inf), border, std::nextafter(border, inf)}) {
        CAPTURE(k, n, x);
        const auto voxel = grid->voxel_at({x, 0, 0});
        REQUIRE(voxel.has_value());
        REQUIRE((voxel->x() == n + half || (x < border && voxel->x() == n + half - 1)));
        REQUIRE(std::floor(grid->to_voxels({x, 0, 0}).x()) == voxel->x());
      }
    }
  }
  // The case that adding half alone gets wrong: a hair below the border at the Earth's centre.
  const auto grid = Grid::standard();
  REQUIRE(grid.voxel_at({-1e-300, 0, 0})->x() == grid.half_voxels() - 1);
  REQUIRE(grid.to_voxels({-1e-300, 0, 0}).x() < grid.half_voxels());
}

TEST_CASE("a Grid refuses what is not on the cube, and names the value", "[grid]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const double bad = GENERATE_COPY(6.4e6, -6.4000001e6, 1e300, -1e300, nan, inf, -inf);
  const int axis = GENERATE(0, 1, 2);
  const int k = GENERATE(1, 7, 10, 20);
  const auto grid = Grid::create(k);
  Eigen::Vector3d p_ecef(1, 2, 3);
  p_ecef[axis] = bad;
  const auto tile = grid->tile_at(p_ecef);
  REQUIRE_FALSE(tile.has_value());
  REQUIRE(tile.error().code == ErrorCode::kOutOfRange);
  const std::string named = std::string("ECEF ") + "xyz"[axis] + " = ";
  REQUIRE_THAT(tile.error().message, Catch::StartsWith(named));
  REQUIRE_FALSE(grid->voxel_at(p_ecef).has_value());
}

TEST_CASE("the cube owns its lower faces and not its upper ones", "[grid]") {
  for (int k = 1; k <= 20; ++k) {
    const auto grid = Grid::create(k);
    const double upper = std::nextafter(6.4e6, 0);
    REQUIRE(grid->voxel_at({-6.4e6, -6.4e6, -6.4e6}) == VoxelIndex(0, 0, 0));
    REQUIRE(grid->tile_at({-6.4e6, -6.4e6, -6.4e6})->morton() == 0);
    // The last double below may round onto the face when multiplied: refused then, never wrapped.
    const auto last = grid->voxel_at({upper, upper, upper});
    const int end = 2 * grid->half_voxels();
    REQUIRE((!last || *last == VoxelIndex(end - 1, end - 1, end - 1)));
    REQUIRE(grid->voxel_at({6'399'999.99, 0, 0})->x() == end - 1);
    REQUIRE(grid->holds({0, 0, end - 1}));
    REQUIRE_FALSE(grid->holds({0, 0, end}));
    REQUIRE_FALSE(grid->holds({-1, 0, 0}));
  }
}

TEST_CASE("a Grid's sizes follow equation 4", "[grid]") {
  REQUIRE(Grid::standard() == *Grid::create(10));
  REQUIRE_FALSE(Grid::standard() == *Grid::create(11));
  REQUIRE(Grid::standard().tiles_per_axis() == 1'000'000);
  REQUIRE(Grid::standard().tile_length() == 12.8);
  REQUIRE(Grid::standard().cell_length(0) == 12.8);
  REQUIRE(Grid::standard().cell_length(4) == 0.8);
  REQUIRE(Grid::standard().cell_length(7) == 0.1);
  for (int k = 1; k <= 20; ++k) {
    const auto grid = Grid::create(k);
    REQUIRE(grid->tiles_per_axis() == 100'000u * static_cast<unsigned>(k));
    REQUIRE(std::uint32_t(2 * grid->half_voxels()) == grid->tiles_per_axis() * 128);
  }
  const int bad = GENERATE(0, -1, 21, 1 << 30);
  const auto refused = Grid::create(bad);
  REQUIRE_FALSE(refused.has_value());
  REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(refused.error().message, Catch::Contains(std::to_string(bad)));
}

TEST_CASE("a Grid knows the keys of its own tiles only", "[grid]") {
  const auto grid = Grid::standard();
  const auto last = test::morton_by_bits({999'999, 999'999, 999'999});
  REQUIRE(grid.tile_from_morton(last).has_value());
  const auto off =
      GENERATE(test::morton_by_bits({1'000'000, 0, 0}), test::morton_by_bits({0, 1'000'000, 0}),
               test::morton_by_bits({0, 0, 1'048'575}), std::uint64_t{1} << 63, ~std::uint64_t{0});
  const auto refused = grid.tile_from_morton(off);
  REQUIRE_FALSE(refused.has_value());
  REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("boxes of tiles and cells meet without a gap and hold what they say", "[grid]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 5'000; ++i) {
    const auto grid = *Grid::create(1 + i % 20);
    const auto tiles = grid.tiles_per_axis();
    Index3 index{};
    for (auto& n : index) n = static_cast<std::uint32_t>(rng() % (tiles - 1));
    const auto tile = *TileKey::from_index(index);
    const Box box = grid.box(tile);
    REQUIRE(box.min == grid.min_corner(tile));
    const auto beyond = *TileKey::from_index({index[0] + 1, index[1] + 1, index[2] + 1});
    REQUIRE(box.max == grid.box(beyond).min);
    REQUIRE(grid.tile_at(box.max) == beyond);

    Index3 voxel{};
    for (auto& n : voxel) n = static_cast<std::uint32_t>(rng() % kTileVoxels);
    const int depth = static_cast<int>(rng() % 8);
    const auto cell = CellKey::of_voxel(voxel, depth);
    const Box cell_box = grid.box(tile, cell);
    const VoxelIndex lowest = *grid.voxel_at(cell_box.min);
    REQUIRE(grid.tile_of(lowest) == tile);
    REQUIRE(Grid::in_tile(lowest) == cell.min_voxel());
    REQUIRE(CellKey::of_voxel(Grid::in_tile(lowest), depth) == cell);
    const double edge = (cell_box.max - cell_box.min).maxCoeff();
    REQUIRE(edge == Approx(grid.cell_length(depth)).margin(2e-9));
  }
}

}  // namespace
}  // namespace voxatlas
