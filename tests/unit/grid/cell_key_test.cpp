#include "grid/cell_key.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"
#include "unit/grid/morton_bits.hpp"

namespace voxatlas {
namespace {

Index3 any_voxel(std::mt19937_64& rng) {
  Index3 voxel{};
  for (auto& n : voxel) n = static_cast<std::uint32_t>(rng() % kTileVoxels);
  return voxel;
}

TEST_CASE("a CellKey is the Morton code of whole cell edges", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 50'000; ++i) {
    const int depth = i % (kDepth + 1);
    const auto edge = 128u / (1u << depth);
    const Index3 voxel = any_voxel(rng);
    const auto cell = CellKey::of_voxel(voxel, depth);
    REQUIRE(cell.depth == depth);
    REQUIRE(cell.edge_voxels() == edge);
    REQUIRE(cell.code == test::morton_by_bits({voxel[0] / edge, voxel[1] / edge, voxel[2] / edge}));
    const Index3 corner{voxel[0] / edge * edge, voxel[1] / edge * edge, voxel[2] / edge * edge};
    REQUIRE(cell.min_voxel() == corner);
    REQUIRE(CellKey::of_voxel(corner, depth) == cell);
  }
}

TEST_CASE("a CellKey's parent holds it, and its children make it up", "[grid]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 10'000; ++i) {
    const int depth = i % kDepth;
    const Index3 voxel = any_voxel(rng);
    const auto cell = CellKey::of_voxel(voxel, depth);
    const auto below = CellKey::of_voxel(voxel, depth + 1);
    REQUIRE(below.parent() == cell);
    const auto half = below.edge_voxels();
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const auto child = cell.child(octant);
      REQUIRE(child.parent() == cell);
      auto corner = cell.min_voxel();
      for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] += (octant >> axis & 1) * half;
      REQUIRE(child.min_voxel() == corner);
    }
  }
}

TEST_CASE("a CellKey contains another when the other's voxels all lie in it", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  int contained = 0;
  for (int i = 0; i < 50'000; ++i) {
    const Index3 voxel = any_voxel(rng);
    Index3 near = voxel;
    for (auto& n : near) n = static_cast<std::uint32_t>(n ^ rng() % 8) % kTileVoxels;
    const auto a = CellKey::of_voxel(voxel, static_cast<int>(rng() % 8));
    const auto b = CellKey::of_voxel(near, static_cast<int>(rng() % 8));
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a_min = a.min_voxel()[axis];
      const auto b_min = b.min_voxel()[axis];
      inside &= b_min >= a_min && b_min + b.edge_voxels() <= a_min + a.edge_voxels();
    }
    contained += inside;
    REQUIRE(a.contains(b) == inside);
  }
  REQUIRE(contained > 5'000);
  REQUIRE(contained < 45'000);
}

}  // namespace
}  // namespace voxatlas
