#include "octree/cell_set.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <tuple>

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

/// Oracle: for_each's order, spelt out.
bool comes_before(CellKey a, CellKey b) {
  const auto rank = [](CellKey cell) {
    const Index3 v = cell.min_voxel();
    const std::uint32_t brick = cell.depth <= 4 ? cell.code : cell.code >> 3 * (cell.depth - 4);
    return cell.depth <= 4 ? std::tuple(brick, 0u, 0u, 0u) : std::tuple(brick, v[2], v[1], v[0]);
  };
  return rank(a) < rank(b);
}

TEST_CASE("a CellSet is a set of cells, at every depth", "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int round = 0; round < 200; ++round) {
    CellSet cells;
    cells.depth = round % 8;
    std::set<CellKey> wanted;
    REQUIRE(cells.valid());
    REQUIRE(cells.empty());
    for (std::uint32_t i = random.below(300); i > 0; --i) {
      const CellKey cell = random.cell_at(cells.depth);
      cells.insert(cell);
      wanted.insert(cell);
    }
    REQUIRE(cells.valid());
    REQUIRE(cells.size() == wanted.size());
    std::vector<CellKey> walked;
    cells.for_each([&](CellKey cell) { walked.push_back(cell); });
    REQUIRE(std::is_sorted(walked.begin(), walked.end(), comes_before));
    REQUIRE(std::set<CellKey>(walked.begin(), walked.end()) == wanted);
    REQUIRE(walked.size() == wanted.size());
    for (int i = 0; i < 100; ++i) {
      const CellKey cell = random.cell_at(cells.depth);
      REQUIRE(cells.contains(cell) == (wanted.count(cell) != 0));
    }
  }
}

TEST_CASE("a CellSet that breaks its layout is not valid", "[octree]") {
  const BrickMask one{7, {1}};
  REQUIRE(CellSet{7, {}, {one}}.valid());
  REQUIRE(CellSet{4, std::vector<std::uint64_t>(64, 1), {}}.valid());
  REQUIRE_FALSE(CellSet{8, {}, {}}.valid());
  REQUIRE_FALSE(CellSet{-1, {}, {}}.valid());
  REQUIRE_FALSE(CellSet{7, {1}, {one}}.valid());
  REQUIRE_FALSE(CellSet{7, {}, {one, one}}.valid());
  REQUIRE_FALSE(CellSet{7, {}, {{9, {1}}, one}}.valid());
  REQUIRE_FALSE(CellSet{7, {}, {{4096, {1}}}}.valid());
  REQUIRE_FALSE(CellSet{7, {}, {{7, {}}}}.valid());
  REQUIRE_FALSE(CellSet{6, {}, {one}}.valid());
  REQUIRE(CellSet{6, {}, {{7, {0x0303, 0x0303}}}}.valid());
  REQUIRE_FALSE(CellSet{6, {}, {{7, {0x0606, 0x0606}}}}.valid());
  REQUIRE_FALSE(CellSet{5, {}, {{7, {0x0303, 0x0303}}}}.valid());
  REQUIRE_FALSE(CellSet{4, std::vector<std::uint64_t>(64), {}}.valid());
  REQUIRE_FALSE(CellSet{4, {1}, {}}.valid());
  REQUIRE_FALSE(CellSet{4, std::vector<std::uint64_t>(64, 1), {one}}.valid());
  REQUIRE_FALSE(CellSet{0, {2}, {}}.valid());
  REQUIRE_FALSE(CellSet{1, {256}, {}}.valid());
  REQUIRE(CellSet{1, {255}, {}}.valid());
  REQUIRE(CellSet{2, {~0ull}, {}}.valid());
}

}  // namespace
}  // namespace voxatlas
