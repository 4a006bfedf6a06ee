#include "integrate/carve.hpp"

#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <tuple>

#include "grid/walk.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Place = std::tuple<std::uint64_t, std::uint32_t, std::uint32_t>;  // Tile, brick, bit.

/// Every mark, by tile, brick and bit; at depth 0..4 all bricks are 0.
std::set<Place> places(const Marks& marks) {
  std::set<Place> out;
  for (std::uint32_t slot = 0; slot < marks.tile_count(); ++slot) {
    const auto& tile = marks.tile(slot);
    for (std::uint32_t top = 0; top < kBricks; ++top) {
      if (!tile.has(top)) continue;
      if (!marks.has_bricks()) out.insert({tile.id, 0, top});
      if (!marks.has_bricks()) continue;
      const auto& bits = marks.bits(marks.brick_slot_of(slot, top));
      for (std::uint32_t bit = 0; bit < 512; ++bit) {
        if (bits[bit >> 6] >> (bit & 63) & 1) out.insert({tile.id, top, bit});
      }
    }
  }
  return out;
}

std::set<Place> by_walk(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, int depth) {
  Marks marks;
  marks.reset(depth);
  Walk walk(origin, end, kDepth - depth);
  while (walk.remaining() > 0) {
    set_mark(marks, walk.cell());
    walk.step();
  }
  return places(marks);
}

TEST_CASE("a carved ray marks the cells that Walk visits before its last, at every depth",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const int depth = GENERATE(range(0, 8));
  std::uniform_real_distribution<double> offset(-300, 300);
  Carver carver;
  for (int i = 0; i < 2'000; ++i) {
    // Short and long rays; some points on borders, some rays along an axis, in a plane or diagonal.
    const double reach = i % 5 == 0 ? 1 : i % 5 == 1 ? 0.02 : 0.1;
    const auto point = [&] {
      Eigen::Vector3d p = Eigen::Vector3d::Constant(105'463'592);
      for (int a = 0; a < 3; ++a) p[a] += reach * offset(rng);
      if (rng() % 2 == 0) p = p.array().round();
      return p;
    };
    const Eigen::Vector3d origin = point();
    Eigen::Vector3d end = point();
    const auto kind = rng() % 8;
    if (kind < 3) end[static_cast<int>(kind)] = origin[static_cast<int>(kind)];
    if (kind == 3) end.tail<2>() = origin.tail<2>();
    if (kind == 4) end = origin + Eigen::Vector3d(1, rng() % 2 ? 1 : -1, -1) * (end - origin).x();
    Marks marks;
    marks.reset(depth);
    carver.carve(origin, end, marks);
    marks.merge();
    CAPTURE(depth, i, origin.transpose(), end.transpose());
    REQUIRE((places(marks) == by_walk(origin, end, depth)));
  }
}

TEST_CASE("every set of instructions that this processor has marks the same cells",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> offset(-900, 900);
  const auto targets = hwy::SupportedAndGeneratedTargets();
  for (int i = 0; i < 300; ++i) {
    const auto point = [&] {
      Eigen::Vector3d p = Eigen::Vector3d::Constant(105'463'592);
      for (int a = 0; a < 3; ++a) p[a] += offset(rng);
      if (rng() % 2 == 0) p = p.array().round();
      return p;
    };
    const Eigen::Vector3d origin = point(), end = point();
    const auto oracle = by_walk(origin, end, kDepth);
    for (const auto target : targets) {
      hwy::SetSupportedTargetsForTest(target);
      Marks marks;
      Carver().carve(origin, end, marks);
      marks.merge();
      hwy::SetSupportedTargetsForTest(0);
      CAPTURE(hwy::TargetName(target), i);
      REQUIRE((places(marks) == oracle));
    }
  }
}

TEST_CASE("marks forget everything on reset, at any sequence of depths", "[integrate]") {
  Marks marks;
  for (const int depth : {7, 2, 5, 0, 7, 4, 6}) {
    marks.reset(depth);
    REQUIRE(marks.tile_count() == 0);
    for (int i = 0; i < 3'000; ++i) set_mark(marks, {(i * 37) << depth, i % 5 << depth, i});
    marks.reset(depth);
    set_mark(marks, {5 << depth, 6 << depth, 7});
    REQUIRE(places(marks).size() == 1);
  }
}

}  // namespace
}  // namespace voxatlas
