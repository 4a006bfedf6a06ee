#pragma once

#include <filesystem>
#include <vector>

#include "integrate/scan.hpp"

namespace voxatlas::test {

/// Scans of a street by a 64-beam scanner driving along it, 15 360 rays each, the same every time.
/// Ground, house fronts, cars and poles are planes and boxes, tilted in ECEF as in Karlsruhe.
std::vector<Scan> street_scans(int count);

/// Where real scans are looked for: VOX_DATA from the environment, else beside the checkout.
std::filesystem::path data_folder();

/// The first scans of kitti_0005 in data_folder(), every fourth point; empty where there are none.
std::vector<Scan> real_scans(std::size_t count);

}  // namespace voxatlas::test
