#pragma once

#include "octree/tile_tree.hpp"

namespace voxatlas {

/// Adds what `other` knows of the same tile to `tile`, as if its scans had come here, too.
///
/// Source:  the paper's section 3.2: models are merged tile by tile. A voxel known to both gets the
///          sum of their log-odds, clamped; one known to one keeps that state. Two colours become
///          their mean, weighted by their counts; below log-odds 0 there is none.
/// Limits:  only the sum is clamped, not each update on the way: where a model had reached a clamp,
///          merging differs from integrating all scans into one.
void merge_tile(TileTree& tile, const TileTree& other, const SensorModel& model);

}  // namespace voxatlas
