#include "unit/integrate/test_scans.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "io/kitti.hpp"

namespace voxatlas::test {
namespace {

struct SolidBox {
  Eigen::Vector3d min, max;
};

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr int kRings = 64, kColumns = 240;

/// The street in its own frame: x along it, z up.
std::vector<SolidBox> street() {
  std::vector<SolidBox> boxes{
      {{-200, -200, -3}, {200, 200, 0}}, {{-60, 8, 0}, {70, 20, 12}}, {{-50, -21, 0}, {40, -9, 9}}};
  for (double x = -45; x < 60; x += 13) {
    boxes.push_back({{x, 5.1, 0.2}, {x + 4.3, 6.9, 1.5}});      // A parked car.
    boxes.push_back({{x + 6, -6.9, 0}, {x + 6.2, -6.7, 5.5}});  // A lamp post.
  }
  return boxes;
}

/// Distance to the first box along a ray of length 1, kNone where there is none.
double first_hit(const std::vector<SolidBox>& boxes, const Eigen::Vector3d& from,
                 const Eigen::Vector3d& direction) {
  double first = kNone;
  for (const auto& box : boxes) {
    double enter = 0, leave = kNone;
    for (int a = 0; a < 3; ++a) {
      const double t0 = (box.min[a] - from[a]) / direction[a];
      const double t1 = (box.max[a] - from[a]) / direction[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    if (enter < leave) first = std::min(first, enter);
  }
  return first;
}

}  // namespace

std::vector<Scan> street_scans(int count) {
  const auto boxes = street();
  const Eigen::Vector3d place(4146358.29, 613973.24, 4791461.94);
  const Eigen::Matrix3d ecef_from_street = (Eigen::AngleAxisd(0.147, Eigen::Vector3d::UnitZ()) *
                                            Eigen::AngleAxisd(0.715, Eigen::Vector3d::UnitY()) *
                                            Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()))
                                               .toRotationMatrix();
  std::vector<Scan> scans;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_street(1.37 * i, 0.11 * i, 1.73);
    Scan scan;
    scan.origin_ecef = place + ecef_from_street * p_street;
    scan.sigma = 0.02;
    for (int ray = 0; ray < kRings * kColumns; ++ray) {
      const double up = (3 - 28.0 * (ray % kRings) / kRings) * std::numbers::pi / 180;
      const double left = 2 * std::numbers::pi * (ray / kRings + 0.37 * i) / kColumns;
      const Eigen::Vector3d towards(std::cos(up) * std::cos(left), std::cos(up) * std::sin(left),
                                    std::sin(up));
      const double range = first_hit(boxes, p_street, towards);
      if (range == kNone) continue;
      scan.endpoints_ecef.push_back(place + ecef_from_street * (p_street + range * towards));
    }
    scans.push_back(std::move(scan));
  }
  return scans;
}

std::filesystem::path data_folder() {
  const char* folder = std::getenv("VOX_DATA");
  return folder != nullptr ? folder : VOX_DATA_DEFAULT;
}

std::vector<Scan> real_scans(std::size_t count) {
  const auto folder = KittiFolder::open(data_folder() / "kitti_0005",
                                        {.poses = "poses_refined_ecef.txt", .origin = {}});
  std::vector<Scan> scans;
  for (std::size_t i = 0; folder && i < std::min(count, folder->scan_count()); ++i) {
    const auto read = folder->read(i);
    if (!read) break;
    scans.push_back(to_scan(read->scan, 0.02, 0));
    auto& ends = scans.back().endpoints_ecef;
    for (std::size_t kept = 0; 4 * kept < ends.size(); ++kept) ends[kept] = ends[4 * kept];
    ends.resize((ends.size() + 3) / 4);
  }
  return scans;
}

}  // namespace voxatlas::test
