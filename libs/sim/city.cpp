#include "sim/city.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "geodesy/enu_frame.hpp"
#include "sim/city_plan.hpp"
#include "sim/ground.hpp"

namespace voxatlas {
namespace {

constexpr double kStillCell = 2.5, kMovingCell = 6;  // Metres; found by trying.
constexpr double kGap = 0.4;                         // Between the scanning car and others.

/// Whether two rectangles are apart along an axis of length 1 (separating axes).
bool apart(const Eigen::Vector2d& axis, const KeptClear& a, const Vehicle& b) {
  const Eigen::Vector2d left(-a.forward.y(), a.forward.x());
  const double reach_a =
      a.half_length * std::abs(a.forward.dot(axis)) + a.half_width * std::abs(left.dot(axis));
  const double reach_b = b.half_size().dot(axis.cwiseAbs());
  return std::abs((a.centre - b.centre).dot(axis)) > reach_a + reach_b + kGap;
}

bool overlap(const KeptClear& a, const Vehicle& b) {
  const Eigen::Vector2d left(-a.forward.y(), a.forward.x());
  return !apart({1, 0}, a, b) && !apart({0, 1}, a, b) && !apart(a.forward, a, b) &&
         !apart(left, a, b);
}

std::vector<Vehicle> clear_traffic(std::uint64_t seed, double seconds,
                                   const std::optional<KeptClear>& clear) {
  auto vehicles = plan_traffic(seed, seconds);
  if (clear) std::erase_if(vehicles, [&](const Vehicle& v) { return overlap(*clear, v); });
  return vehicles;
}

std::vector<Solid> bodies(const std::vector<Vehicle>& vehicles) {
  std::vector<Solid> solids;
  for (const Vehicle& vehicle : vehicles) add_vehicle(solids, vehicle);
  return solids;
}

}  // namespace

Result<City> City::create(const CityOptions& options) {
  auto frame = EnuFrame::at(options.place);
  if (!frame) return pass_on(frame, "the city's place");
  const double bearing = options.bearing_deg * std::numbers::pi / 180;
  Eigen::Matrix3d turn;
  turn << std::cos(bearing), -std::sin(bearing), 0, std::sin(bearing), std::cos(bearing), 0, 0, 0,
      1;
  auto ecef_from_city =
      Pose::create(frame->ecef_from_enu().rotation() * turn, frame->origin_ecef());
  if (!ecef_from_city) return pass_on(ecef_from_city, "the city's place");
  return City(options.seed, *ecef_from_city);
}

City::City(std::uint64_t seed, const Pose& ecef_from_city)
    : seed_(seed), ecef_from_city_(ecef_from_city), still_(plan_still(seed), kStillCell) {}

Eigen::Vector3d City::to_city(const Eigen::Vector3d& p_ecef) const {
  return ecef_from_city_.rotation().transpose() * (p_ecef - ecef_from_city_.translation());
}

Instant::Instant(const City& city, double seconds, const std::optional<KeptClear>& clear)
    : city_(city),
      vehicles_(clear_traffic(city.seed(), seconds, clear)),
      moving_(bodies(vehicles_), kMovingCell) {}

Instant::Sight Instant::look(const Beam& beam, double max_range) const {
  Sight sight;
  double limit = max_range;
  if (const auto hit = Ground::first_hit(beam, limit); hit.t < limit) {
    sight = {hit.t, hit.material, hit.colour, false};
    limit = hit.t;
  }
  if (const auto hit = city_.still().first_hit(beam, limit); hit.solid != nullptr) {
    sight = {hit.t, hit.solid->material, hit.solid->colour, false};
    limit = hit.t;
  }
  if (const auto hit = moving_.first_hit(beam, limit); hit.solid != nullptr) {
    sight = {hit.t, hit.solid->material, hit.solid->colour, true};
  }
  return sight;
}

Instant::Nearest Instant::nearest(const Eigen::Vector3d& p_city, double limit) const {
  Nearest nearest;
  if (const double distance = Ground::signed_distance(p_city); distance < limit) {
    nearest = {distance, Ground::look(p_city.x(), p_city.y()).material, false};
    limit = distance;
  }
  // A point below the ground may lie in a foundation, but nothing is nearer there than the surface.
  const double search = std::max(limit, 0.0);
  if (const auto hit = city_.still().nearest(p_city, search); hit.solid && hit.t < limit) {
    nearest = {hit.t, hit.solid->material, false};
    limit = hit.t;
  }
  if (const auto hit = moving_.nearest(p_city, search); hit.solid && hit.t < limit) {
    nearest = {hit.t, hit.solid->material, true};
  }
  return nearest;
}

}  // namespace voxatlas
