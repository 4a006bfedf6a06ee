#include <malloc.h>
#include <octomap/OcTree.h>

#include <memory>

#include "bench/import_case.hpp"
#include "octree/log_odds.hpp"

namespace voxatlas::bench {
namespace {

/// OctoMap's own structures for one case.
struct OctomapMap {
  octomap::OcTree fine{0.1};
  octomap::OcTree coarse{0.8};  ///< Free space at 80 cm, as OctoMap has one depth a tree.

  OctomapMap() {
    const auto model = SensorModel::standard();
    for (auto* tree : {&fine, &coarse}) {
      tree->setProbHit(to_probability(model.hit));
      tree->setProbMiss(to_probability(model.miss));
      tree->setClampingThresMin(to_probability(model.clamp_min));
      tree->setClampingThresMax(to_probability(model.clamp_max));
    }
  }
};

octomap::point3d to_point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

void insert_surface(octomap::OcTree& tree, const octomap::Pointcloud& cloud,
                    const octomap::point3d& origin, double max_range) {
  octomap::KeySet hits;
  for (const auto& p : cloud) {
    if ((p - origin).norm() <= max_range) hits.insert(tree.coordToKey(p));
  }
  for (const auto& key : hits) tree.updateNode(key, true, true);
}

void insert_free(octomap::OcTree& tree, const octomap::Pointcloud& cloud,
                 const octomap::point3d& origin, double max_range) {
  octomap::KeySet misses, hits;
  tree.computeUpdate(cloud, origin, misses, hits, max_range);
  for (const auto& key : misses) tree.updateNode(key, false, true);
}

void insert(OctomapMap& map, const octomap::Pointcloud& cloud, const octomap::point3d& origin,
            const IntegrationParameters& parameters) {
  if (parameters.free_depth == kDepth) {
    map.fine.insertPointCloud(cloud, origin, parameters.max_range, true);
    return;
  }
  if (parameters.free_depth >= 0) insert_free(map.coarse, cloud, origin, parameters.max_range);
  insert_surface(map.fine, cloud, origin, parameters.max_range);
}

}  // namespace

ImportTiming import_octomap(const std::vector<Scan>& scans, const IntegrationParameters& how,
                            double seconds) {
  constexpr std::size_t kFewest = 4;
  const Eigen::Vector3d corner = (scans.front().origin_ecef / 64).array().round() * 64;
  const double before = resident_bytes();
  Stopwatch watch;
  const auto map = std::make_unique<OctomapMap>();
  for (const auto& scan : scans) {
    if (watch.scans() >= kFewest && watch.total_cpu() > seconds) break;
    octomap::Pointcloud cloud;
    cloud.reserve(scan.endpoints_ecef.size());
    for (const auto& p : scan.endpoints_ecef) cloud.push_back(to_point(p - corner));
    watch.start();
    insert(*map, cloud, to_point(scan.origin_ecef - corner), how);
    watch.stop(scan.endpoints_ecef.size());
  }
  watch.start();
  for (auto* tree : {&map->fine, &map->coarse}) {
    tree->updateInnerOccupancy();
    tree->prune();
  }
  auto timing = watch.finish();
  malloc_trim(0);
  timing.resident_bytes = resident_bytes() - before;
  return timing;
}

}  // namespace voxatlas::bench
