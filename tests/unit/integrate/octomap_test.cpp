// The integrator and the tiles against OctoMap, an implementation by others of the same updates.
#include <octomap/OcTree.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "integrate/integrator.hpp"
#include "octree/tile_tree.hpp"
#include "support/slow_build.hpp"
#include "unit/integrate/test_scans.hpp"

namespace voxatlas {
namespace {

/// OctoMap computes in float: offsets of multiples of 2^-16 m below this many metres are exact.
constexpr double kExactReach = 128;
constexpr int kOctomapOrigin = 32768;

/// A corner of tiles near a point, 64 m apart, so that its coordinates in metres are exact.
Eigen::Vector3d exact_corner(const Eigen::Vector3d& p_ecef) {
  return (p_ecef / 64).array().round() * 64;
}

/// The scan moved onto multiples of 2^-16 m, without what OctoMap's floats could not hold exactly
/// or would measure as beyond the range.
Scan exact_scan(Scan scan, const Eigen::Vector3d& corner, double max_range) {
  const auto rounded = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return corner + Eigen::Vector3d(((p - corner) * 65536).array().round() / 65536);
  };
  scan.origin_ecef = rounded(scan.origin_ecef);
  std::vector<Eigen::Vector3d> kept;
  for (const auto& end : scan.endpoints_ecef) {
    const Eigen::Vector3d p = rounded(end);
    if ((p - corner).cwiseAbs().maxCoeff() < kExactReach &&
        (p - scan.origin_ecef).norm() < max_range - 0.01) {
      kept.push_back(p);
    }
  }
  scan.endpoints_ecef = std::move(kept);
  return scan;
}

octomap::point3d to_point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// OctoMap's tree with the sensor model's very values: its setters round them to the same floats.
octomap::OcTree octomap_tree(const SensorModel& model) {
  octomap::OcTree tree(0.1);
  tree.setProbHit(to_probability(model.hit));
  tree.setProbMiss(to_probability(model.miss));
  tree.setClampingThresMin(to_probability(model.clamp_min));
  tree.setClampingThresMax(to_probability(model.clamp_max));
  REQUIRE(tree.getProbHitLog() == static_cast<float>(to_float_log_odds(model.hit)));
  REQUIRE(tree.getProbMissLog() == static_cast<float>(to_float_log_odds(model.miss)));
  REQUIRE(tree.getClampingThresMinLog() == static_cast<float>(to_float_log_odds(model.clamp_min)));
  REQUIRE(tree.getClampingThresMaxLog() == static_cast<float>(to_float_log_odds(model.clamp_max)));
  return tree;
}

void insert(octomap::OcTree& tree, const Scan& scan, const Eigen::Vector3d& corner) {
  octomap::Pointcloud cloud;
  for (const auto& p : scan.endpoints_ecef) cloud.push_back(to_point(p - corner));
  tree.insertPointCloud(cloud, to_point(scan.origin_ecef - corner), -1, true);
}

using Tiles = std::map<TileKey, TileTree>;

/// The part of [0, 1] of a segment within a box grown by `margin`; empty where first > second.
std::pair<double, double> inside(const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
                                 const Box& box, double margin) {
  double enter = 0, leave = 1;
  for (int a = 0; a < 3; ++a) {
    const double low = box.min[a] - margin - origin[a], high = box.max[a] + margin - origin[a];
    const double d = end[a] - origin[a];
    if (d == 0) {
      if (low > 0 || high < 0) leave = -1;
    } else {
      enter = std::max(enter, std::min(low / d, high / d));
      leave = std::min(leave, std::max(low / d, high / d));
    }
  }
  return {enter, leave};
}

/// True where shifting the voxel's borders by 2e-5 m decides whether the segment passes it.
bool grazes(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, const Box& voxel) {
  constexpr double kClose = 2e-5;
  const auto wide = inside(origin, end, voxel, kClose);
  const auto narrow = inside(origin, end, voxel, -kClose);
  return wide.first <= wide.second && narrow.first > narrow.second;
}

/// True where some ray grazes the voxel or ends on its border: OctoMap leaves a ray's last cell out
/// where its float length is shorter than the way to that cell's border.
bool grazed(const std::vector<Scan>& scans, const Box& voxel) {
  return std::any_of(scans.begin(), scans.end(), [&](const Scan& scan) {
    return std::any_of(scan.endpoints_ecef.begin(), scan.endpoints_ecef.end(),
                       [&](const Eigen::Vector3d& end) {
                         return grazes(scan.origin_ecef, end, voxel) || grazes(end, end, voxel);
                       });
  });
}

struct Comparison {
  std::uint64_t voxels = 0;  ///< Known to OctoMap.
  std::vector<VoxelIndex> different;
};

/// Adds the voxels of ours that OctoMap does not know.
void add_unknown(const octomap::OcTree& tree, const Tiles& tiles, const VoxelIndex& corner,
                 std::vector<VoxelIndex>& out) {
  const auto visit = [&](const VoxelIndex& voxel) {
    const VoxelIndex local = (voxel - corner).array() + kOctomapOrigin;
    const octomap::OcTreeKey at(static_cast<octomap::key_type>(local.x()),
                                static_cast<octomap::key_type>(local.y()),
                                static_cast<octomap::key_type>(local.z()));
    if (tree.search(at) == nullptr) out.push_back(voxel);
  };
  for (const auto& tile : tiles) {
    tile.second.for_each_leaf([&](const Leaf& leaf) {
      const auto low = leaf.cell.min_voxel();
      const auto edge = leaf.cell.edge_voxels();
      for (std::uint32_t i = 0; i < edge * edge * edge; ++i) {
        visit(Grid::min_voxel(tile.first) + VoxelIndex(static_cast<int>(low[0] + i % edge),
                                                       static_cast<int>(low[1] + i / edge % edge),
                                                       static_cast<int>(low[2] + i / edge / edge)));
      }
    });
  }
}

Comparison compare(const octomap::OcTree& tree, const Tiles& tiles, const VoxelIndex& corner,
                   const Grid& grid) {
  Comparison comparison;
  std::uint64_t both = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (leaf.getDepth() != 16) FAIL("OctoMap pruned a tree that nobody told to");
    ++comparison.voxels;
    const auto key = leaf.getKey();
    const VoxelIndex voxel = corner + VoxelIndex(key[0] - kOctomapOrigin, key[1] - kOctomapOrigin,
                                                 key[2] - kOctomapOrigin);
    const auto tile = tiles.find(grid.tile_of(voxel));
    const auto ours = tile == tiles.end() ? std::nullopt : tile->second.voxel(Grid::in_tile(voxel));
    both += ours.has_value();
    const float theirs = leaf->getLogOdds();
    if (!ours || static_cast<float>(to_float_log_odds(ours->log_odds)) != theirs) {
      comparison.different.push_back(voxel);
    }
  }
  std::uint64_t known = 0;
  for (const auto& [key, tile] : tiles) {
    const auto counts = tile.counts();
    known += counts.occupied_voxels + counts.free_voxels;
  }
  if (known != both) add_unknown(tree, tiles, corner, comparison.different);
  return comparison;
}

/// Every difference lies where a ray grazes a border, and there are fewer than one in 100 000 of
/// the cells that the scans changed: each scan grazes its own, so they add up over scans as those
/// cells do, while the voxels of a place that is seen again and again do not.
void require_like_octomap(std::vector<Scan> scans) {
  const IntegrationParameters parameters{7, 7, 0, 120};
  const auto grid = Grid::standard();
  const auto model = SensorModel::standard();
  // In the middle, as what lies far from it is not compared.
  const auto corner = exact_corner(scans[scans.size() / 2].origin_ecef);
  auto tree = octomap_tree(model);
  Integrator integrator(grid, parameters);
  Tiles tiles;
  std::uint64_t changes = 0;
  for (auto& scan : scans) {
    scan = exact_scan(std::move(scan), corner, parameters.max_range);
    insert(tree, scan, corner);
    const auto delta = integrator.integrate(scan);
    REQUIRE(delta.has_value());
    REQUIRE(delta->counts.hits == scan.endpoints_ecef.size());
    changes += delta->counts.cells_missed + delta->counts.cells_hit;
    for (const auto& [key, change] : delta->tiles) tiles[key].apply(change, model);
  }
  const auto comparison = compare(tree, tiles, *grid.voxel_at(corner), grid);
  UNSCOPED_INFO(comparison.different.size()
                << " of " << comparison.voxels << " voxels differ, after " << changes
                << " changes of one");
  REQUIRE(comparison.voxels > 100'000);
  for (const auto& voxel : comparison.different) {
    CAPTURE(voxel.transpose());
    const VoxelIndex next = voxel + VoxelIndex::Ones();
    REQUIRE(grazed(scans, {grid.min_corner(voxel), grid.min_corner(next)}));
  }
  REQUIRE(comparison.different.size() * 100'000 < changes);
}

void require_real_like_octomap(std::size_t count) {
  const auto scans = test::real_scans(count);
  if (scans.empty()) {
    WARN("skipped: no real scans in " << test::data_folder() << " (VOX_DATA)");
    return;
  }
  REQUIRE(scans.size() == count);
  require_like_octomap(scans);
}

TEST_CASE("simulated scans leave the voxels that OctoMap leaves, bit for bit but at grazed edges",
          "[integrate][oracle]") {
  require_like_octomap(test::street_scans(test::kSlowBuild ? 1 : 5));
}

TEST_CASE("real scans leave the voxels that OctoMap leaves, bit for bit but at grazed edges",
          "[integrate][oracle]") {
  require_real_like_octomap(test::kSlowBuild ? 1 : 3);
}

// The same at length; Catch2 runs neither unless told to.
TEST_CASE("100 simulated scans leave the voxels that OctoMap leaves", "[.long]") {
  require_like_octomap(test::street_scans(100));
}

TEST_CASE("40 real scans leave the voxels that OctoMap leaves", "[.long]") {
  require_real_like_octomap(40);
}

}  // namespace
}  // namespace voxatlas
