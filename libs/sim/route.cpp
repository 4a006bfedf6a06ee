#include "sim/route.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/ground.hpp"
#include "sim/random.hpp"

namespace voxatlas {
namespace {

constexpr int kStreets = Ground::kBlocks - 1;
constexpr double kRight = 4.5, kLeft = 6;  // Radii of turns on the lane.
constexpr double kQuarter = std::numbers::pi / 2;

/// A crossing, by the streets that cross, and a way out of it: east, north, west, south.
struct Crossing {
  int x, y;

  Crossing after(int way) const {
    constexpr std::array<int, 4> dx{1, 0, -1, 0}, dy{0, 1, 0, -1};
    const auto i = static_cast<std::size_t>(way);
    return {x + dx[i], y + dy[i]};
  }
  bool exists() const { return x >= 0 && x < kStreets && y >= 0 && y < kStreets; }
  Eigen::Vector2d middle() const {
    return Eigen::Vector2d(x - kStreets / 2, y - kStreets / 2) * Ground::kPitch;
  }
  /// One name for a street between two crossings, whichever way it is driven.
  int street(int way) const {
    const Crossing other = after(way);
    return (std::min(x, other.x) * kStreets + std::min(y, other.y)) * 2 + way % 2;
  }
};

Eigen::Vector2d direction(double heading) { return {std::cos(heading), std::sin(heading)}; }
Eigen::Vector2d right_of(double heading) { return {std::sin(heading), -std::cos(heading)}; }

Route::Place advance(const Route::Place& from, double length, double curvature) {
  if (curvature == 0) return {from.p + length * direction(from.heading), from.heading};
  const double heading = from.heading + length * curvature;
  const Eigen::Vector2d chord(std::sin(heading) - std::sin(from.heading),
                              std::cos(from.heading) - std::cos(heading));
  return {from.p + chord / curvature, heading};
}

/// The ways on from a crossing, least driven first; never back.
int choose(const Crossing& at, int way, std::map<int, int>& driven, Draw& draw) {
  int best = -1;
  double fewest = 0;
  for (const int turn : {0, 1, 3}) {
    const int next = (way + turn) % 4;
    if (!at.after(next).exists()) continue;
    const double score = driven[at.street(next)] + 0.5 * draw.unit();
    if (best < 0 || score < fewest) {
      best = next;
      fewest = score;
    }
  }
  ++driven[at.street(best)];
  return best;
}

}  // namespace

Route::Route(std::uint64_t seed, double length) {
  Draw draw{seed, 0x726f757465};
  Crossing ahead{3, 2};
  int way = 0;
  std::map<int, int> driven;
  tip_ = {ahead.middle() - Eigen::Vector2d(42, kLane), 0};
  while (end_ < length) {
    const int next = choose(ahead, way, driven, draw);
    const int turn = (next - way + 4) % 4;  // 0 on, 1 left, 3 right.
    const double out = (turn == 1 ? 1 : -1) * kQuarter + tip_.heading;
    const double radius = turn == 0 ? 0 : turn == 1 ? kLeft : kRight;
    const Eigen::Vector2d corner =
        ahead.middle() + kLane * right_of(tip_.heading) +
        (turn == 0 ? Eigen::Vector2d::Zero() : Eigen::Vector2d(kLane * right_of(out)));
    add((corner - tip_.p).dot(direction(tip_.heading)) - radius, 0);
    if (turn != 0) add(radius * kQuarter, (turn == 1 ? 1 : -1) / radius);
    way = next;
    ahead = ahead.after(way);
  }
}

void Route::add(double length, double curvature) {
  pieces_.push_back({end_, tip_, curvature});
  tip_ = advance(tip_, length, curvature);
  end_ += length;
}

Route::Place Route::at(double along) const {
  const double s = std::clamp(along, 0.0, end_);
  const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), s,
                                      [](double v, const Piece& piece) { return v < piece.begin; });
  const Piece& piece = *(after - 1);
  return advance(piece.start, s - piece.begin, piece.curvature);
}

}  // namespace voxatlas
