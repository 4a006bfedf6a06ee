#include "atlas/tile_merge.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

TileTree random_tree(test::RandomOctree& random) {
  TileTree tree;
  for (auto cells = random.below(12); cells > 0; --cells) tree.set(random.cell(), random.state());
  for (auto deltas = random.below(4); deltas > 0; --deltas) {
    tree.apply(random.delta(), random.model());
  }
  return tree;
}

/// Oracle: one voxel at a time, in floating point where colours are concerned.
std::string difference(const std::optional<CellState>& a, const std::optional<CellState>& b,
                       const std::optional<CellState>& sum, const SensorModel& model) {
  if (!a || !b) return sum == (a ? a : b) ? "" : "known to one, but changed";
  if (!sum) return "known to both, and forgotten";
  const int expected =
      std::clamp(a->log_odds + b->log_odds, int{model.clamp_min}, int{model.clamp_max});
  if (sum->log_odds != expected) return "log-odds";
  const int counts = a->colour.count + b->colour.count;
  if (expected < 0 || counts == 0) return sum->colour.exists() ? "a colour from nowhere" : "";
  if (sum->colour.count != std::min(counts, 16)) return "the colour's count";
  for (std::size_t i = 0; i < 3; ++i) {
    const double mean =
        (1.0 * a->colour.mean[i] * a->colour.count + 1.0 * b->colour.mean[i] * b->colour.count) /
        counts;
    if (std::abs(mean - sum->colour.mean[i]) > 0.5) return "the colour";
  }
  return "";
}

TEST_CASE("a merged tile is, voxel by voxel, the clamped sum of both", "[atlas][oracle]") {
  test::RandomOctree random(test::engine()());
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 5; ++i) {
    const TileTree a = random_tree(random), b = random_tree(random);
    TileTree sum = a;
    merge_tile(sum, b, random.model());
    std::string first;
    for (std::uint32_t code = 0; code < 1u << 21 && first.empty(); ++code) {
      const Index3 voxel = CellKey{kDepth, code}.min_voxel();
      first = difference(a.voxel(voxel), b.voxel(voxel), sum.voxel(voxel), random.model());
    }
    CAPTURE(i);
    REQUIRE(first == "");
  }
}

TEST_CASE("merging with a tile that knows nothing changes nothing", "[atlas]") {
  test::RandomOctree random(test::engine()());
  const TileTree a = random_tree(random);
  TileTree sum = a, other;
  merge_tile(sum, TileTree(), random.model());
  merge_tile(other, a, random.model());
  REQUIRE(sum == a);
  REQUIRE(other == a);
}

}  // namespace
}  // namespace voxatlas
