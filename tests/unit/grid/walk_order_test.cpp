// What the integrator builds on: the walks of one ray in cells of different size agree.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "grid/walk.hpp"
#include "support/engine.hpp"
#include "unit/grid/rays.hpp"

namespace voxatlas {
namespace {

using test::Ray;
using Cells = std::vector<Eigen::Vector3i>;

/// Oracle: each cell's parent, repetitions in a row dropped.
Cells parents_of(const Cells& cells, int shift) {
  Cells parents;
  for (const auto& cell : cells) {
    const Eigen::Vector3i parent(cell.x() >> shift, cell.y() >> shift, cell.z() >> shift);
    if (parents.empty() || parents.back() != parent) parents.push_back(parent);
  }
  return parents;
}

TEST_CASE("a coarse Walk visits exactly the parents of the fine one's cells", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 6'000; ++i) {
    const Ray ray = test::any_ray(rng, i % 10 == 0 ? 3000 : 200);
    CAPTURE(ray.origin.transpose(), ray.end.transpose());
    const Cells fine = test::cells_of(ray, 0);
    for (int shift = 1; shift <= 7; ++shift) {
      REQUIRE(test::cells_of(ray, shift) == parents_of(fine, shift));
    }
  }
}

bool less(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

using CellSet = std::set<Eigen::Vector3i, decltype(&less)>;

/// One crossing's place in the order of the whole ray.
using Moment = std::pair<double, int>;

/// When the ray enters the tile, and when it leaves it, by the tile's own six faces.
std::pair<Moment, Moment> stay_in(const Eigen::Vector3i& tile, const Ray& ray) {
  const double inf = std::numeric_limits<double>::infinity();
  Moment enter{-inf, 0};
  Moment leave{inf, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const double d = ray.end[axis] - ray.origin[axis];
    if (static_cast<int>(ray.origin[axis]) >> 7 == static_cast<int>(ray.end[axis]) >> 7) continue;
    const double inverse = 1 / d;
    const double near = 128.0 * (d > 0 ? tile[axis] : tile[axis] + 1);
    const double far = 128.0 * (d > 0 ? tile[axis] + 1 : tile[axis]);
    if (tile[axis] != static_cast<int>(ray.origin[axis]) >> 7) {
      enter = std::max(enter, {(near - ray.origin[axis]) * inverse, axis});
    }
    if (tile[axis] != static_cast<int>(ray.end[axis]) >> 7) {
      leave = std::min(leave, {(far - ray.origin[axis]) * inverse, axis});
    }
  }
  return {enter, leave};
}

/// Oracle: the cells of the ray cut to the tile, each axis counted on its own: the cell at a moment
/// is the origin's cell plus the borders crossed by then.
CellSet cells_in(const Eigen::Vector3i& tile, const Ray& ray) {
  std::vector<std::pair<Moment, Eigen::Vector3i>> steps;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = static_cast<int>(ray.origin[axis]);
    const int last = static_cast<int>(ray.end[axis]);
    const double inverse = 1 / (ray.end[axis] - ray.origin[axis]);
    Eigen::Vector3i step = Eigen::Vector3i::Zero();
    step[axis] = last > first ? 1 : -1;
    for (int border = std::min(first, last) + 1; border <= std::max(first, last); ++border) {
      steps.push_back({{(border - ray.origin[axis]) * inverse, axis}, step});
    }
  }
  std::sort(steps.begin(), steps.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto [enter, leave] = stay_in(tile, ray);
  CellSet cells(&less);
  Eigen::Vector3i cell = ray.origin.cast<int>();
  std::size_t next = 0;
  while (next < steps.size() && steps[next].first <= enter) cell += steps[next++].second;
  cells.insert(cell);
  while (next < steps.size() && steps[next].first < leave) {
    cell += steps[next++].second;
    cells.insert(cell);
  }
  return cells;
}

TEST_CASE("a ray cut at tile borders visits the same cells as the whole", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 1'500; ++i) {
    const Ray ray = test::any_ray(rng, 600);
    CAPTURE(ray.origin.transpose(), ray.end.transpose());
    std::map<Eigen::Vector3i, CellSet, decltype(&less)> by_tile(&less);
    for (const auto& cell : test::cells_of(ray, 0)) {
      const Eigen::Vector3i tile(cell.x() >> 7, cell.y() >> 7, cell.z() >> 7);
      by_tile.try_emplace(tile, &less).first->second.insert(cell);
    }
    const Cells tiles = test::cells_of(ray, 7);
    REQUIRE(tiles.size() == by_tile.size());
    for (const auto& tile : tiles) {
      const auto found = by_tile.find(tile);
      REQUIRE(found != by_tile.end());
      REQUIRE(found->second == cells_in(tile, ray));
    }
  }
}

TEST_CASE("a Walk back takes as many steps, through cells the ray touches", "[grid]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 3'000; ++i) {
    const Ray ray = test::any_ray(rng, 100);
    const Ray back{ray.end, ray.origin};
    const Cells there = test::cells_of(ray, 0);
    const Cells again = test::cells_of(back, 0);
    REQUIRE(there.size() == again.size());
    REQUIRE(there.front() == again.back());
    REQUIRE(there.back() == again.front());
    const Eigen::Vector3d d = ray.end - ray.origin;
    for (const auto& cell : again) {
      double enter = 0;
      double leave = 1;
      for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) continue;
        const double a = (cell[axis] - ray.origin[axis]) / d[axis];
        const double b = (cell[axis] + 1 - ray.origin[axis]) / d[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (enter > leave + 1e-12) FAIL("cell " << cell.transpose() << " lies off the ray");
    }
  }
}

}  // namespace
}  // namespace voxatlas
