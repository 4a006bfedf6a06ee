#include "render/street_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxatlas {
namespace {

constexpr double kBlock = 4;  // Metres: the ground is one height in a block.
constexpr int kBlocks = static_cast<int>(2 * StreetMap::kReach / kBlock);
constexpr int kSquares = static_cast<int>(2 * StreetMap::kReach / StreetMap::kSquare);
constexpr double kKnee = 0.6, kOverhead = 3.0;     // Metres above ground: what stands there blocks.
constexpr double kHalfWidth = 1.2, kWiden = 0.15;  // Metres to each side of a way; and a metre.
constexpr double kWidest = 2.5;
constexpr double kSteepest = 0.12;  // Streets rise less; a roof's "ground" is no street.

std::size_t at(int x, int y, int side) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x);
}

bool inside(int x, int y, int side) { return x >= 0 && y >= 0 && x < side && y < side; }

std::vector<Eigen::Vector3f> cells_in(const EnuFrame& frame, const Grid& grid,
                                      std::span<const PlacedCloud> clouds) {
  std::vector<Eigen::Vector3f> cells;
  const Eigen::Matrix3d enu_from_ecef = frame.ecef_from_enu().rotation().transpose();
  for (const auto& placed : clouds) {
    const Eigen::Vector3d corner = frame.to_enu(grid.min_corner(placed.key));
    for (const DrawnCell& cell : placed.cloud->cells()) {
      const Eigen::Vector3d offset = cell.centre_voxels().cast<double>() / grid.cells_per_metre();
      const Eigen::Vector3d p = corner + enu_from_ecef * offset;
      if (p.head<2>().cwiseAbs().maxCoeff() < StreetMap::kReach) cells.push_back(p.cast<float>());
    }
  }
  return cells;
}

/// The height below which a tenth of a block's cells lie: no single mirrored point decides.
float low_height(std::vector<float>& heights) {
  constexpr std::size_t kFewest = 12;
  if (heights.size() < kFewest) return std::numeric_limits<float>::quiet_NaN();
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 10);
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

}  // namespace

StreetMap::Square StreetMap::square_of(const Eigen::Vector2d& p, double edge) {
  return {static_cast<int>(std::floor((p.x() + kReach) / edge)),
          static_cast<int>(std::floor((p.y() + kReach) / edge))};
}

StreetMap::StreetMap(const EnuFrame& frame, const Grid& grid, std::span<const PlacedCloud> clouds)
    : cells_(cells_in(frame, grid, clouds)) {
  std::vector<std::vector<float>> heights(std::size_t{kBlocks} * kBlocks);
  for (const auto& p : cells_) {
    const auto [x, y] = square_of(p.head<2>().cast<double>(), kBlock);
    if (inside(x, y, kBlocks)) heights[at(x, y, kBlocks)].push_back(p.z());
  }
  ground_.resize(heights.size());
  std::transform(heights.begin(), heights.end(), ground_.begin(), low_height);
  blocked_.resize(std::size_t{kSquares} * kSquares);
  for (const auto& p : cells_) {
    const Eigen::Vector2d place = p.head<2>().cast<double>();
    const auto [x, y] = square_of(place, kSquare);
    const auto floor = ground(place);
    if (!floor || !inside(x, y, kSquares)) continue;
    const double above = p.z() - *floor;
    if (above > kKnee && above < kOverhead) blocked_[at(x, y, kSquares)] = true;
  }
}

std::optional<double> StreetMap::ground(const Eigen::Vector2d& p) const {
  const auto [x, y] = square_of(p, kBlock);
  if (!inside(x, y, kBlocks) || std::isnan(ground_[at(x, y, kBlocks)])) return std::nullopt;
  return ground_[at(x, y, kBlocks)];
}

bool StreetMap::blocked(const Eigen::Vector2d& p, double radius) const {
  const auto [low_x, low_y] = square_of(p - Eigen::Vector2d::Constant(radius), kSquare);
  const auto [high_x, high_y] = square_of(p + Eigen::Vector2d::Constant(radius), kSquare);
  for (int y = low_y; y <= high_y; ++y) {
    for (int x = low_x; x <= high_x; ++x) {
      if (inside(x, y, kSquares) && blocked_[at(x, y, kSquares)]) return true;
    }
  }
  return false;
}

double StreetMap::clear_way(const Eigen::Vector2d& p, const Eigen::Vector2d& direction,
                            double limit) const {
  const auto start = ground(p);
  if (!start) return 0;
  double clear = 0;
  while (clear < limit) {
    const Eigen::Vector2d next = p + (clear + kSquare) * direction;
    const auto floor = ground(next);
    if (!floor || std::abs(*floor - *start) > 0.5 + kSteepest * clear) break;
    if (blocked(next, std::min(kHalfWidth + kWiden * clear, kWidest))) break;
    clear += kSquare;
  }
  return clear;
}

double StreetMap::outlook(const Eigen::Vector3d& eye, const Eigen::Vector2d& direction) const {
  constexpr int kColumns = 40, kRows = 20;
  constexpr double kHalfWide = 0.84, kLow = -0.45, kHigh = 0.35;  // Tangents: 40, -24, 19 degrees.
  std::vector<bool> covered(std::size_t{kColumns} * kRows);
  const Eigen::Vector2d right(direction.y(), -direction.x());
  for (const auto& p : cells_) {
    const Eigen::Vector3d offset = p.cast<double>() - eye;
    const double ahead = offset.head<2>().dot(direction);
    if (ahead < 4 || ahead > 60) continue;
    const double x = offset.head<2>().dot(right) / ahead / kHalfWide;
    const double y = (offset.z() / ahead - kLow) / (kHigh - kLow);
    if (std::abs(x) >= 1 || y < 0 || y >= 1) continue;
    covered[at(static_cast<int>((x + 1) / 2 * kColumns), static_cast<int>(y * kRows), kColumns)] =
        true;
  }
  // What stands up makes a street; ground alone does not: rows above the horizon count twice.
  constexpr int kHorizon = static_cast<int>(-kLow / (kHigh - kLow) * kRows);
  const auto middle = covered.begin() + kHorizon * kColumns;
  const auto below = std::count(covered.begin(), middle, true);
  const auto above = std::count(middle, covered.end(), true);
  return static_cast<double>(below + 2 * above) /
         (kHorizon * kColumns + 2.0 * (kRows - kHorizon) * kColumns);
}

}  // namespace voxatlas
