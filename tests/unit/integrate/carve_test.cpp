#include "integrate/carve.hpp"

#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "grid/walk.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Place = std::tuple<Index3, std::uint32_t, std::uint32_t>;  // Tile, brick, bit.
constexpr std::uint32_t kReach = 64;                             ///< Tiles: more than any ray here.

/// Every mark, by tile, brick and bit; at depth 0..4 all bricks are 0.
std::set<Place> places(const Marks& marks) {
  std::set<Place> out;
  for (std::uint32_t slot = 0; slot < marks.tile_count(); ++slot) {
    const auto& tile = marks.tile(slot);
    for (std::uint32_t top = 0; top < kBricks; ++top) {
      if (!tile.has(top)) continue;
      if (!marks.has_bricks()) out.insert({tile.index, 0, top});
      if (!marks.has_bricks()) continue;
      const auto& bits = marks.bits(marks.brick_slot_of(slot, top));
      for (std::uint32_t bit = 0; bit < 512; ++bit) {
        if (bits[bit >> 6] >> (bit & 63) & 1) out.insert({tile.index, top, bit});
      }
    }
  }
  return out;
}

std::set<Place> by_walk(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, int depth) {
  Marks marks;
  marks.reset(depth, kReach);
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
  const double scale = std::ldexp(1.0, depth - kDepth);
  std::uniform_real_distribution<double> offset(-300, 300);
  Marks carved, marks;
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
    carved.reset(kDepth, kReach);
    marks.reset(depth, kReach);
    carve(origin * scale, end * scale, carved);
    carved.merge();
    add_cells(carved, marks);
    CAPTURE(depth, i, origin.transpose(), end.transpose());
    REQUIRE((places(marks) == by_walk(origin, end, depth)));
  }
}

TEST_CASE("a ray that misses corners and edges by a hair marks the cells that Walk visits",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  // Through lattice points, and beside them by 2^-15 to 2^-26 of a voxel: what the vectors' fixed
  // point can tell, what it must refuse, and the limit between the two.
  const auto hair = [&] {
    const auto steps = static_cast<int>(rng() % 5) - 2;
    return std::ldexp(steps, -15 - static_cast<int>(rng() % 12));
  };
  const auto lattice = [&](int reach) -> Eigen::Vector3d {
    Eigen::Vector3d p;
    for (int a = 0; a < 3; ++a) p[a] = static_cast<int>(rng() % (2u * reach + 1)) - reach;
    return p;
  };
  Marks marks;
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Vector3d origin = Eigen::Vector3d::Constant(105'463'592) + lattice(20);
    Eigen::Vector3d end = origin + lattice(4) * static_cast<double>(1 + rng() % 20);
    for (int a = 0; a < 3; ++a) {
      origin[a] += hair() + (rng() % 4 == 0 ? 0.5 : 0);
      end[a] += hair() + (rng() % 4 == 0 ? 0.5 : 0);
    }
    marks.reset(kDepth, kReach);
    carve(origin, end, marks);
    marks.merge();
    CAPTURE(i, (origin.array() - 105'463'592).transpose(), (end - origin).transpose());
    REQUIRE((places(marks) == by_walk(origin, end, kDepth)));
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
      marks.reset(kDepth, kReach);
      carve(origin, end, marks);
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
    marks.reset(depth, kReach);
    REQUIRE(marks.tile_count() == 0);
    for (int i = 0; i < 3'000; ++i) {
      const int tile = (1 << 19) + i % static_cast<int>(kReach);
      set_mark(marks, {tile << depth, i % 5 << depth, i});
    }
    marks.reset(depth, kReach);
    set_mark(marks, {5 << depth, 6 << depth, 7});
    REQUIRE(places(marks).size() == 1);
  }
}

}  // namespace
}  // namespace voxatlas
