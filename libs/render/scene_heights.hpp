#pragma once

#include <vector>

#include "render/shade.hpp"

namespace voxatlas {

/// Where a scene's ground is and how high it rises, from the heights of some of its cells; the
/// defaults where there are none.
SceneHeights heights_of(const Eigen::Vector3d& up_ecef, std::vector<double> samples);

}  // namespace voxatlas
