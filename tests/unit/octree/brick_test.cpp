#include "octree/brick.hpp"

#include <hwy/targets.h>

#include <catch2/catch.hpp>

#include "octree/log_odds.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Sparse, dense, empty and full masks.
VoxelMask random_mask(std::mt19937_64& rng) {
  VoxelMask mask{};
  const auto kind = rng() % 4;
  for (auto& word : mask) {
    word = kind == 0 ? 0 : kind == 1 ? ~0ull : kind == 2 ? rng() : rng() & rng() & rng() & rng();
    if (rng() % 3 == 0) word = 0;
  }
  return mask;
}

LogOdds random_log_odds(std::mt19937_64& rng, int low, int high) {
  const auto span = static_cast<std::uint64_t>(high - low + 1);
  const auto edge = rng() % 4;
  const int value = edge == 0 ? low : edge == 1 ? high : low + static_cast<int>(rng() % span);
  return static_cast<LogOdds>(value);
}

TEST_CASE("a brick's update is SensorModel::update, voxel by voxel, with every set of instructions",
          "[octree][oracle]") {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 3000; ++round) {
    const SensorModel model{random_log_odds(rng, 1, 32767), random_log_odds(rng, -32767, -1),
                            random_log_odds(rng, -32767, -1), random_log_odds(rng, 0, 32767)};
    Brick brick;
    brick.known = random_mask(rng);
    for_each_bit(brick.known, [&](unsigned voxel) {
      brick.log_odds[voxel] = random_log_odds(rng, -32767, 32767);
    });
    const Brick before = brick;
    const VoxelMask misses = random_mask(rng), hits = random_mask(rng);
    const auto target = targets[static_cast<std::size_t>(round) % targets.size()];
    hwy::SetSupportedTargetsForTest(target);
    update(brick, misses, hits, model);
    hwy::SetSupportedTargetsForTest(0);
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      LogOdds wanted = before.log_odds[voxel];
      if (has_voxel(misses, voxel)) wanted = model.update(wanted, model.miss);
      if (has_voxel(hits, voxel)) wanted = model.update(wanted, model.hit);
      const bool known =
          has_voxel(before.known, voxel) || has_voxel(misses, voxel) || has_voxel(hits, voxel);
      if (brick.log_odds[voxel] != wanted || has_voxel(brick.known, voxel) != known) {
        CAPTURE(hwy::TargetName(target), round, voxel, before.log_odds[voxel], model.hit,
                model.miss);
        REQUIRE(brick.log_odds[voxel] == wanted);
        REQUIRE(has_voxel(brick.known, voxel) == known);
      }
    }
  }
}

TEST_CASE("equal voxels are found one by one, with every set of instructions", "[octree][oracle]") {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  constexpr LogOdds kValues[] = {0, -1, 1, -1661, 3471, 32'767, -32'768};
  for (int round = 0; round < 1000; ++round) {
    Brick brick;
    const auto kinds = 1 + rng() % 7;
    for (auto& log_odds : brick.log_odds) log_odds = kValues[rng() % kinds];
    const LogOdds wanted = kValues[rng() % 7];
    const auto target = targets[static_cast<std::size_t>(round) % targets.size()];
    hwy::SetSupportedTargetsForTest(target);
    const VoxelMask equal = equal_to(brick, wanted);
    hwy::SetSupportedTargetsForTest(0);
    CAPTURE(hwy::TargetName(target), round, wanted);
    unsigned count = 0;
    bool right = true;
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      right = right && has_voxel(equal, voxel) == (brick.log_odds[voxel] == wanted);
      count += brick.log_odds[voxel] == wanted ? 1 : 0;
    }
    REQUIRE(right);
    REQUIRE(count_of(equal) == count);
  }
}

TEST_CASE("assign and forget change the voxels of their mask and no other", "[octree][oracle]") {
  auto rng = test::engine();
  Brick brick;
  std::array<int, kBrickVoxels> wanted;  // INT_MAX: unknown.
  wanted.fill(INT32_MAX);
  for (int round = 0; round < 500; ++round) {
    const VoxelMask voxels = random_mask(rng);
    const LogOdds log_odds = random_log_odds(rng, -32767, 32767);
    const bool erases = rng() % 2 == 0;
    erases ? forget(brick, voxels) : assign(brick, voxels, log_odds);
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      if (has_voxel(voxels, voxel)) wanted[voxel] = erases ? INT32_MAX : log_odds;
    }
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      const bool known = wanted[voxel] != INT32_MAX;
      const bool same = has_voxel(brick.known, voxel) == known &&
                        brick.log_odds[voxel] == (known ? wanted[voxel] : 0);
      if (!same) REQUIRE(voxel == kBrickVoxels);
    }
  }
  assign(brick, kAllVoxels, -3);
  REQUIRE(is_uniform(brick));
  brick.log_odds[511] = -2;
  REQUIRE_FALSE(is_uniform(brick));
}

TEST_CASE("a brick's tables agree with CellKey about where voxels and cells are",
          "[octree][oracle]") {
  for (std::uint32_t voxel = 0; voxel < kBrickVoxels; ++voxel) {
    const Index3 at{8 * 3 + voxel % 8, 8 * 5 + voxel / 8 % 8, 8 * 12 + voxel / 64};
    for (int depth = kBrickDepth; depth <= kDepth; ++depth) {
      const CellKey cell = CellKey::of_voxel(at, depth);
      REQUIRE(brick_of(cell) == morton_encode({3, 5, 12}));
      const unsigned lowest = lowest_voxel_of(cell);
      REQUIRE(has_voxel(lowest_voxels(depth), lowest));
      REQUIRE(cell_at(brick_of(cell), lowest, depth) == cell);
      const VoxelMask own = cell_voxels(lowest, depth);
      REQUIRE(has_voxel(own, voxel));
      REQUIRE(count_of(own) == 1u << 3 * (kDepth - depth));
      REQUIRE(count_of(lowest_voxels(depth)) == 1u << 3 * (depth - kBrickDepth));
    }
  }
}

}  // namespace
}  // namespace voxatlas
