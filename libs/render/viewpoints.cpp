#include "render/viewpoints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "render/frustum.hpp"
#include "render/model_extent.hpp"
#include "render/street_map.hpp"

namespace voxatlas {
namespace {

constexpr double kEyeHeight = 2.0;  // Metres above the ground.

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// What is occupied in a tile and its 26 neighbours.
std::uint64_t weight_around(TileKey key, const std::unordered_map<TileKey, std::uint64_t>& tiles) {
  std::uint64_t weight = 0;
  const Index3 index = key.index();
  for (std::uint32_t i = 0; i < 27; ++i) {  // Below 0 an index wraps round and is refused.
    const auto neighbour =
        TileKey::from_index({index[0] + i % 3 - 1, index[1] + i / 3 % 3 - 1, index[2] + i / 9 - 1});
    if (!neighbour) continue;
    if (const auto found = tiles.find(*neighbour); found != tiles.end()) weight += found->second;
  }
  return weight;
}

/// Where a street picture is sought: the middle of the tile with most in it and around it; of
/// equals the one with the lowest key.
Result<Eigen::Vector3d> densest_place(const Grid& grid, std::span<const TileWeight> tiles) {
  std::unordered_map<TileKey, std::uint64_t> occupied;
  for (const auto& tile : tiles) occupied[tile.key] = tile.occupied;
  std::pair<std::uint64_t, TileKey> densest{0, grid.tile_of({0, 0, 0})};
  for (const auto& tile : tiles) {
    const std::pair weight{weight_around(tile.key, occupied), tile.key};
    if (weight.first > densest.first ||
        (weight.first == densest.first && weight.second < densest.second)) {
      densest = weight;
    }
  }
  if (densest.first == 0) {
    return fail(ErrorCode::kNotFound, "no view of a model where nothing is occupied");
  }
  return middle_of(grid, densest.second);
}

struct Stand {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::Vector2d heading = Eigen::Vector2d::Zero();
  double score = 0;
};

/// The ways one could look from a place, by how far they are clear; best first.
std::vector<Stand> clear_stands(const StreetMap& map, const Eigen::Vector2d& long_axis) {
  constexpr double kSearch = 36;    // Metres around the middle.
  constexpr double kFarthest = 40;  // Metres; what is clear beyond makes no better picture.
  const double axis_angle = std::atan2(long_axis.y(), long_axis.x());
  std::vector<Stand> stands;
  for (double x = -kSearch; x <= kSearch; x += 2) {
    for (double y = -kSearch; y <= kSearch; y += 2) {
      const Eigen::Vector2d place(x, y);
      if (!map.ground(place) || map.blocked(place, 2.5)) continue;
      for (int turn = -4; turn <= 4; ++turn) {
        for (const double way : {0.0, 180.0}) {
          const double angle = axis_angle + radians(way + 6.0 * turn);
          const Eigen::Vector2d heading(std::cos(angle), std::sin(angle));
          const double clear = map.clear_way(place, heading, kFarthest);
          if (clear > 0) stands.push_back({place, heading, clear});
        }
      }
    }
  }
  std::stable_sort(stands.begin(), stands.end(),
                   [](const Stand& a, const Stand& b) { return a.score > b.score; });
  return stands;
}

/// Of the clearest ways the one with most to see; score 0: none.
Stand best_stand(const StreetMap& map, const Eigen::Vector2d& long_axis) {
  constexpr std::size_t kLookAt = 150;
  constexpr double kMetresForAFullPicture = 60;
  const auto stands = clear_stands(map, long_axis);
  Stand best;
  const std::size_t every = std::max<std::size_t>(1, stands.size() / 2 / kLookAt);
  for (std::size_t i = 0; i < stands.size() && i < every * kLookAt; i += every) {
    Stand stand = stands[i];
    const Eigen::Vector3d eye(stand.place.x(), stand.place.y(),
                              *map.ground(stand.place) + kEyeHeight);
    stand.score += kMetresForAFullPicture * map.outlook(eye, stand.heading);
    if (stand.score > best.score) best = stand;
  }
  return best;
}

}  // namespace

Result<Camera> oblique_view(const Grid& grid, std::span<const TileWeight> tiles,
                            const ViewSize& size) {
  auto extent = ModelExtent::of(grid, tiles);
  if (!extent) return pass_on(extent);
  constexpr double kFov = 42, kDown = 34, kAside = 25;  // Degrees.
  // The picture's width shows 1.4 deviations to each side of the middle, and at least 30 m.
  const double half_width = std::max(30.0, 1.4 * extent->along);
  const double ratio = static_cast<double>(size.width) / std::max(1, size.height);
  const double away = std::min(1500.0, half_width / (std::tan(radians(kFov / 2)) * ratio));
  const double angle =
      std::atan2(extent->long_axis.y(), extent->long_axis.x()) - radians(90 - kAside);
  const Eigen::Vector3d eye_enu(away * std::cos(radians(kDown)) * std::cos(angle),
                                away * std::cos(radians(kDown)) * std::sin(angle),
                                away * std::sin(radians(kDown)));
  Lens lens = Lens::of_view(kFov, size.width, size.height);
  lens.near_range = 1;
  lens.far_range = std::min(Camera::kMaxRange, 3 * away + 100);
  const EnuFrame& frame = extent->frame;
  return Camera::look_at(frame.to_ecef(eye_enu), frame.origin_ecef(), frame.up_ecef(), lens);
}

std::vector<TileKey> street_tiles(const Grid& grid, std::span<const TileWeight> tiles) {
  const auto place = densest_place(grid, tiles);
  if (!place) return {};
  std::vector<std::pair<double, TileKey>> near;
  for (const auto& tile : tiles) {
    const double metres = distance(grid.box(tile.key), *place);
    if (tile.occupied > 0 && metres < StreetMap::kReach * std::numbers::sqrt2) {
      near.emplace_back(metres, tile.key);
    }
  }
  std::sort(near.begin(), near.end());
  std::vector<TileKey> keys;
  for (const auto& [metres, key] : near) keys.push_back(key);
  return keys;
}

Result<Camera> street_view(const Grid& grid, std::span<const TileWeight> tiles,
                           std::span<const PlacedCloud> clouds, const ViewSize& size) {
  auto extent = ModelExtent::of(grid, tiles);
  if (!extent) return pass_on(extent);
  auto middle = densest_place(grid, tiles);
  if (!middle) return pass_on(middle);
  auto frame = EnuFrame::at(*middle);
  if (!frame) return pass_on(frame);
  const StreetMap map(*frame, grid, clouds);
  const Stand stand = best_stand(map, extent->long_axis);
  if (stand.score <= 0) {
    return fail(ErrorCode::kNotFound,
                fmt::format("no place to stand within {} m of the densest tile: {} tiles seen",
                            StreetMap::kReach, clouds.size()));
  }
  Eigen::Vector3d eye_enu;
  eye_enu << stand.place, *map.ground(stand.place) + kEyeHeight;
  Eigen::Vector3d ahead_enu;
  ahead_enu << stand.heading * 20, -0.8;  // A little down: more street than sky.
  return Camera::look_at(frame->to_ecef(eye_enu), frame->to_ecef(eye_enu + ahead_enu),
                         frame->up_ecef(), Lens::of_view(50, size.width, size.height));
}

Result<Camera> standing_view(const Geodetic& eye, double heading_deg, const ViewSize& size) {
  if (!std::isfinite(heading_deg)) {
    return fail(ErrorCode::kOutOfRange, fmt::format("a heading of {} degrees", heading_deg));
  }
  auto frame = EnuFrame::at(eye);
  if (!frame) return pass_on(frame);
  const double angle = radians(heading_deg);
  const Eigen::Vector3d ahead_enu(20 * std::sin(angle), 20 * std::cos(angle), 0);
  return Camera::look_at(frame->origin_ecef(), frame->to_ecef(ahead_enu), frame->up_ecef(),
                         Lens::of_view(50, size.width, size.height));
}

}  // namespace voxatlas
