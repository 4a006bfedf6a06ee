#include "unit/integrate/scan_oracle.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "integrate/free_rays.hpp"

namespace voxatlas::test {
namespace {

/// A border on the way: where on the ray, on which axis.
struct Crossing {
  double t;
  int axis;
  friend auto operator<=>(const Crossing&, const Crossing&) = default;
};

GlobalCell shifted(GlobalCell cell, int shift) {
  for (auto& c : cell) c >>= shift;
  return cell;
}

std::int64_t half_voxels(int k) { return std::int64_t{6'400'000} * k; }

GlobalCell voxel_of(const Eigen::Vector3d& p, int k) {
  const VoxelIndex voxel = Grid::create(k)->voxel_unchecked(p);
  return {voxel.x(), voxel.y(), voxel.z()};
}

Eigen::Vector3d in_voxels(const Eigen::Vector3d& p, int k) { return Grid::create(k)->to_voxels(p); }

/// Every cell from the origin's to the one before the end's.
std::vector<GlobalCell> cells_before_end(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                         int k, int depth) {
  const int shift = kDepth - depth;
  const double edge = 1 << shift;
  auto cell = shifted(voxel_of(from, k), shift);
  const auto end = shifted(voxel_of(to, k), shift);
  const Eigen::Vector3d o = in_voxels(from, k), e = in_voxels(to, k);
  std::vector<Crossing> crossings;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (auto c = cell[a]; c < end[a]; ++c) {
      crossings.push_back(
          {(static_cast<double>(c + 1) * edge - o[axis]) * (1 / (e[axis] - o[axis])), axis});
    }
    for (auto c = cell[a]; c > end[a]; --c) {
      crossings.push_back(
          {(static_cast<double>(c) * edge - o[axis]) * (1 / (e[axis] - o[axis])), axis});
    }
  }
  std::sort(crossings.begin(), crossings.end());
  std::vector<GlobalCell> cells;
  for (const auto& crossing : crossings) {
    cells.push_back(cell);
    const auto a = static_cast<std::size_t>(crossing.axis);
    cell[a] += end[a] > cell[a] ? 1 : -1;
  }
  REQUIRE(cell == end);
  return cells;
}

bool on_cube(const GlobalCell& voxel, int k) {
  return std::all_of(voxel.begin(), voxel.end(),
                     [&](std::int64_t v) { return v >= 0 && v < 2 * half_voxels(k); });
}

using ColourSums = std::map<GlobalCell, std::array<std::int64_t, 4>>;

std::map<GlobalCell, std::array<int, 3>> means(const ColourSums& sums) {
  std::map<GlobalCell, std::array<int, 3>> colours;
  for (const auto& [cell, sum] : sums) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double mean = static_cast<double>(sum[c]) / static_cast<double>(sum[3]);
      colours[cell][c] = static_cast<int>(std::floor(mean + 0.5));
    }
  }
  return colours;
}

int depth_by_trying(double sigma, double tile_length) {
  int depth = 0;
  while (depth < kDepth && 4 * sigma <= tile_length / (2 << depth)) ++depth;
  return depth;
}

bool frees(const Scan& scan, std::size_t ray, const ScanCells& cells,
           const IntegrationParameters& parameters) {
  const int coarser = cells.hit_depth - cells.miss_depth;
  if (parameters.all_rays_free || coarser <= 0) return true;
  return FreeRays(scan.utime, coarser).has(scan.endpoints_ecef[ray]);
}

void drop_related(ScanCells& cells) {
  const int both = std::min(cells.miss_depth, cells.hit_depth);
  std::set<GlobalCell> taken;
  for (const auto& hit : cells.hits) taken.insert(shifted(hit, cells.hit_depth - both));
  std::erase_if(cells.misses, [&](const GlobalCell& miss) {
    return taken.contains(shifted(miss, cells.miss_depth - both));
  });
}

}  // namespace

ScanCells cells_by_sorting(const Scan& scan, const IntegrationParameters& parameters, int k) {
  ScanCells cells;
  const int depth = depth_by_trying(scan.sigma, 128.0 / k);
  cells.hit_depth = std::min(depth, parameters.surface_depth);
  cells.miss_depth = std::min(depth, std::max(parameters.free_depth, 0));
  ColourSums sums;
  for (std::size_t i = 0; i < scan.endpoints_ecef.size(); ++i) {
    Eigen::Vector3d end = scan.endpoints_ecef[i];
    const Eigen::Vector3d ray = end - scan.origin_ecef;
    if (!std::isfinite(end.sum())) {
      ++cells.not_finite;
      continue;
    }
    if (ray.norm() < std::max(scan.min_range, parameters.min_range)) {
      ++cells.below_min;
      continue;
    }
    const bool beyond = ray.norm() > parameters.max_range;
    if (beyond) {
      const Eigen::Vector3d towards = ray / ray.lpNorm<Eigen::Infinity>();
      end = scan.origin_ecef + towards * (parameters.max_range / towards.norm());
    }
    if (!on_cube(voxel_of(end, k), k)) {
      ++cells.off_cube;
      continue;
    }
    ++(beyond ? cells.beyond_max : cells.rays_hit);
    if (parameters.free_depth >= 0 && frees(scan, i, cells, parameters)) {
      for (const auto& c : cells_before_end(scan.origin_ecef, end, k, cells.miss_depth)) {
        cells.misses.insert(c);
      }
    }
    if (beyond) continue;
    const auto hit = shifted(voxel_of(end, k), kDepth - cells.hit_depth);
    cells.hits.insert(hit);
    if (scan.colours.empty()) continue;
    const auto colour = scan.colours[i];
    auto& sum = sums[hit];
    sum = {sum[0] + colour.r, sum[1] + colour.g, sum[2] + colour.b, sum[3] + 1};
  }
  drop_related(cells);
  cells.colours = means(sums);
  return cells;
}

ScanCells cells_of(const ScanDelta& delta) {
  ScanCells cells;
  const TileKey* previous = nullptr;
  for (const auto& [tile, change] : delta.tiles) {
    REQUIRE((previous == nullptr || *previous < tile));
    previous = &tile;
    REQUIRE_FALSE(change.empty());
    cells.miss_depth = change.misses.depth;
    cells.hit_depth = change.hits.depth;
    const auto global = [corner = Grid::min_voxel(tile)](CellKey cell) {
      const auto low = cell.min_voxel();
      GlobalCell out{};
      for (std::size_t a = 0; a < 3; ++a) {
        out[a] = (corner[static_cast<int>(a)] + static_cast<std::int64_t>(low[a])) >>
                 (kDepth - cell.depth);
      }
      return out;
    };
    for (const auto* set : {&change.misses, &change.hits, &change.coloured}) REQUIRE(set->valid());
    REQUIRE(change.coloured.depth == change.hits.depth);
    change.misses.for_each([&](CellKey c) { REQUIRE(cells.misses.insert(global(c)).second); });
    change.hits.for_each([&](CellKey c) { REQUIRE(cells.hits.insert(global(c)).second); });
    std::size_t i = 0;
    change.coloured.for_each([&](CellKey c) {
      const auto colour = change.colours.at(i++);
      cells.colours[global(c)] = {colour.r, colour.g, colour.b};
    });
    REQUIRE(i == change.colours.size());
  }
  REQUIRE(delta.counts.cells_missed == cells.misses.size());
  REQUIRE(delta.counts.cells_hit == cells.hits.size());
  cells.rays_hit = delta.counts.hits;
  cells.beyond_max = delta.counts.beyond_max;
  cells.below_min = delta.counts.below_min;
  cells.not_finite = delta.counts.not_finite;
  cells.off_cube = delta.counts.off_cube;
  REQUIRE(delta.counts.rays ==
          cells.rays_hit + cells.beyond_max + cells.below_min + cells.not_finite + cells.off_cube);
  return cells;
}

Scan ScanMaker::operator()(std::mt19937_64& rng) const {
  std::uniform_real_distribution<double> offset(-reach, reach);
  const auto on_border = [&](double x) { return std::round(x * k) / k; };
  const auto point = [&] {
    Eigen::Vector3d p = place_ecef;
    const auto kind = rng() % 8;  // 0..2 one axis on a border, 3 all three, the rest anywhere.
    for (int a = 0; a < 3; ++a) {
      p[a] += offset(rng);
      if (kind == 3 || kind == static_cast<std::uint64_t>(a)) p[a] = on_border(p[a]);
    }
    return p;
  };
  Scan scan;
  scan.origin_ecef = point();
  for (std::size_t i = 0; i < rays; ++i) {
    scan.endpoints_ecef.push_back(point());
    if (rng() % 16 == 0) scan.endpoints_ecef.back() = scan.origin_ecef;
    if (rng() % 16 == 0) scan.endpoints_ecef.back().x() = scan.origin_ecef.x();  // On a plane.
    const auto colour = rng();
    if (coloured) {
      scan.colours.push_back({static_cast<std::uint8_t>(colour),
                              static_cast<std::uint8_t>(colour >> 8),
                              static_cast<std::uint8_t>(colour >> 16)});
    }
  }
  return scan;
}

}  // namespace voxatlas::test
