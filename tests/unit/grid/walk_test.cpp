#include "grid/walk.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>

#include "support/engine.hpp"
#include "unit/grid/rays.hpp"

namespace voxatlas {
namespace {

using test::Ray;

/// A step from one cell into the next: over which border, when, and on which axis.
struct Crossing {
  double t;
  int axis;
  int direction;
};

/// Oracle: all borders between the two end cells, listed axis by axis and sorted; no walk.
std::vector<Crossing> crossings_by_sorting(const Ray& ray, int shift) {
  const double size = std::exp2(shift);
  std::vector<Crossing> all;
  for (int axis = 0; axis < 3; ++axis) {
    const double from = ray.origin[axis];
    const double to = ray.end[axis];
    const double inverse = 1 / (to - from);
    const auto first = static_cast<std::int64_t>(std::floor(from / size));
    const auto last = static_cast<std::int64_t>(std::floor(to / size));
    for (std::int64_t border = std::min(first, last) + 1; border <= std::max(first, last);
         ++border) {
      const double t = (static_cast<double>(border) * size - from) * inverse;
      all.push_back({t, axis, last > first ? 1 : -1});
    }
  }
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.t, a.axis) < std::tie(b.t, b.axis);
  });
  return all;
}

TEST_CASE("a Walk crosses what sorting all borders gives, in that order", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::int64_t steps = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Ray ray = test::any_ray(rng, i % 10 == 0 ? 2000 : 40);
    const int shift = i % 8;
    CAPTURE(ray.origin.transpose(), ray.end.transpose(), shift);
    const auto expected = crossings_by_sorting(ray, shift);
    Walk walk(ray.origin, ray.end, shift);
    Eigen::Vector3i cell = (ray.origin.array() / std::exp2(shift)).floor().matrix().cast<int>();
    REQUIRE(walk.cell() == cell);
    REQUIRE(walk.remaining() == static_cast<std::int64_t>(expected.size()));
    for (const auto& crossing : expected) {
      cell[crossing.axis] += crossing.direction;
      if (walk.step() != crossing.axis || walk.cell() != cell) {
        FAIL("at t = " << crossing.t << " of axis " << crossing.axis);
      }
      ++steps;
    }
    REQUIRE(walk.remaining() == 0);
    REQUIRE(walk.cell() == (ray.end.array() / std::exp2(shift)).floor().matrix().cast<int>());
  }
  REQUIRE(steps > 500'000);
}

/// A ray in units of 2^-16 voxel, near the grid's corner: all of its arithmetic fits 64 bits.
struct ExactRay {
  std::array<std::int64_t, 3> origin, end;
};

constexpr std::int64_t kUnit = 1 << 16;

Ray in_voxels(const ExactRay& exact) {
  Ray ray;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    ray.origin[axis] = static_cast<double>(exact.origin[a]) / kUnit;
    ray.end[axis] = static_cast<double>(exact.end[a]) / kUnit;
  }
  return ray;
}

/// t of a step as a fraction with a positive denominator.
struct Fraction {
  std::int64_t above, below;
};

/// Where the exact ray crosses the border between `cell` and the next on `axis`.
Fraction exact_t(const ExactRay& ray, std::size_t axis, int cell) {
  const std::int64_t d = ray.end[axis] - ray.origin[axis];
  const std::int64_t border = (d > 0 ? cell + 1 : cell) * kUnit;
  const std::int64_t sign = d > 0 ? 1 : -1;
  return {sign * (border - ray.origin[axis]), sign * d};
}

/// a - b; numerators and denominators are below 2^30, so that the products are exact.
double difference(Fraction a, Fraction b) {
  return static_cast<double>(a.above * b.below - b.above * a.below) /
         (static_cast<double>(a.below) * static_cast<double>(b.below));
}

/// A ray whose differences are powers of two, so that t is exact in double too: equal fractions
/// are ties, and must go x before y before z.
ExactRay tying_ray(std::mt19937_64& rng) {
  ExactRay ray{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto d = std::int64_t{1} << (15 + rng() % 9);
    ray.origin[axis] = d + static_cast<std::int64_t>(rng() % 64) * (kUnit / 4);
    ray.end[axis] = ray.origin[axis] + (rng() % 2 == 0 ? d : -d);
  }
  return ray;
}

TEST_CASE("a Walk keeps the order of exact fractions", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  int ties = 0;
  for (int i = 0; i < 4'000; ++i) {
    const bool exact = i % 2 == 0;
    ExactRay ray = tying_ray(rng);
    if (!exact) {
      for (auto& n : ray.origin) n = static_cast<std::int64_t>(rng() % (1 << 25));
      for (auto& n : ray.end) n = static_cast<std::int64_t>(rng() % (1 << 25));
    }
    const Ray voxels = in_voxels(ray);
    CAPTURE(voxels.origin.transpose(), voxels.end.transpose());
    Walk walk(voxels.origin, voxels.end, 0);
    Fraction before{0, 1};
    int axis_before = 0;
    while (walk.remaining() > 0) {
      const Eigen::Vector3i cell = walk.cell();
      const int axis = walk.step();
      const Fraction t = exact_t(ray, static_cast<std::size_t>(axis), cell[axis]);
      const double later = difference(t, before);
      if (exact && later == 0) {
        ++ties;
        if (axis < axis_before) FAIL("a tie out of order");
      }
      if (later < (exact ? 0 : -0x1p-50)) FAIL("steps back by " << later);
      before = t;
      axis_before = axis;
    }
    REQUIRE(difference(before, {1, 1}) <= 0);
  }
  REQUIRE(ties > 10'000);
}

TEST_CASE("a Walk without length, or within one cell, stays", "[grid]") {
  const Eigen::Vector3d p(64'000'000, 5.25, 0);
  REQUIRE(Walk(p, p, 0).remaining() == 0);
  REQUIRE(Walk(p, p + Eigen::Vector3d(0.99, 0.5, 0.1), 0).remaining() == 0);
  REQUIRE(Walk(p, p, 7).cell() == Eigen::Vector3i(500'000, 0, 0));
}

TEST_CASE("a Walk parallel to an axis leaves the others alone, borders or not", "[grid]") {
  const int axis = GENERATE(0, 1, 2);
  const double beside = GENERATE(7.0, 7.5);
  const int direction = GENERATE(1, -1);
  Eigen::Vector3d origin = Eigen::Vector3d::Constant(beside);
  Eigen::Vector3d end = origin;
  origin[axis] = 20;
  end[axis] = 20 + 10 * direction;
  Walk walk(origin, end, 0);
  Eigen::Vector3i cell(7, 7, 7);
  cell[axis] = 20;
  REQUIRE(walk.remaining() == 10);
  while (walk.remaining() > 0) {
    REQUIRE(walk.step() == axis);
    cell[axis] += direction;
    REQUIRE(walk.cell() == cell);
  }
}

TEST_CASE("a Walk from a border downwards leaves its cell at once", "[grid]") {
  Walk walk({10, 3.5, 3.5}, {8, 3.5, 3.5}, 0);
  REQUIRE(walk.cell().x() == 10);  // The cell owns its lower face: the origin lies in 10.
  REQUIRE(walk.remaining() == 2);
  walk.step();
  walk.step();
  REQUIRE(walk.cell().x() == 8);
}

TEST_CASE("a Walk along the diagonal steps x, y, z in turn", "[grid]") {
  Walk walk({0, 0, 0}, {5, 5, 5}, 0);
  for (int i = 0; i < 15; ++i) REQUIRE(walk.step() == i % 3);
  REQUIRE(walk.cell() == Eigen::Vector3i(5, 5, 5));
}

TEST_CASE("a Walk crosses the whole of the finest grid", "[grid]") {
  const double far = 256'000'000;
  Walk walk({0, 0, 0.5}, {far - 0.5, far - 1, 0.5}, 7);
  REQUIRE(walk.remaining() == 2 * 1'999'999);
  while (walk.remaining() > 0) walk.step();
  REQUIRE(walk.cell() == Eigen::Vector3i(1'999'999, 1'999'999, 0));
}

}  // namespace
}  // namespace voxatlas
