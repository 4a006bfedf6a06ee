#include "integrate/carve.hpp"

#include "grid/walk.hpp"
#include "integrate/carve_steps.hpp"

namespace voxatlas {

void carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels, Marks& misses) {
  if (carve_steps(origin_voxels, end_voxels, misses)) return;
  for (Walk walk(origin_voxels, end_voxels, 0); walk.remaining() > 0; walk.step()) {
    set_mark(misses, walk.cell());
  }
}

}  // namespace voxatlas
