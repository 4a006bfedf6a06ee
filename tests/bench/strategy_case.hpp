#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "integrate/integrator.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::bench {

/// What one strategy took. A plain value, so that a child process can hand it over a pipe.
struct StrategyCost {
  double seconds = 0;      ///< Of the wall.
  double peak_bytes = 0;   ///< How far the process grew at its largest, model included.
  double queue_bytes = 0;  ///< The rays waiting for their tiles, at most.
  double tiles = 0, occupied_voxels = 0;
};

/// The strategy the paper chose: cells are gathered ray by ray, each once a scan, then tiles are
/// updated. It is ours: Integrator and TileTree::apply, one thread.
StrategyCost ray_based(const std::vector<Scan>& scans, const IntegrationParameters& how);

/// The other one: rays are first queued at every tile they pass, then each tile takes its rays and
/// updates its octree directly, cell by cell, so cells count as often as rays pass them.
///
/// Source:  the paper's section 4.1.
/// at_once: how many scans are queued before tiles are updated.
/// threads: tiles are taken by so many.
StrategyCost tile_based(const std::vector<Scan>& scans, const IntegrationParameters& how,
                        std::size_t at_once, std::size_t threads);

}  // namespace voxatlas::bench
