#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "geodesy/pose.hpp"
#include "sim/solid_grid.hpp"
#include "sim/things.hpp"

namespace voxatlas {

struct CityOptions {
  std::uint64_t seed = 1;
  /// Of the city's middle. The city campus of TUM Munich, where the paper's vehicle drove.
  Geodetic place{48.1489, 11.5680, 560};
  double bearing_deg = 22;  ///< How far the streets called x are turned from east to north.
};

/// A procedural city that knows itself: the same options give the same city.
///
/// Frame:   the city's: a local frame at `place`, z up (plumb), x and y along the streets; the
///          ground is tilted in it (Ground), and all of it is oblique in ECEF.
/// Cost:    some 50 000 solids, 10 MB, tens of milliseconds to make.
/// Threads: unchanging once made; safe to share.
class City {
 public:
  /// Errors: kOutOfRange for a place that is not on the Earth.
  [[nodiscard]] static Result<City> create(const CityOptions& options);

  const Pose& ecef_from_city() const { return ecef_from_city_; }
  Eigen::Vector3d to_city(const Eigen::Vector3d& p_ecef) const;

  /// Everything that never moves, but for the ground.
  const SolidGrid& still() const { return still_; }

  std::uint64_t seed() const { return seed_; }

 private:
  City(std::uint64_t seed, const Pose& ecef_from_city);

  std::uint64_t seed_;
  Pose ecef_from_city_;
  SolidGrid still_;
};

/// A rectangle on the plan that is kept free of moving vehicles: where the scanning car is.
struct KeptClear {
  Eigen::Vector2d centre, forward;  ///< `forward` has length 1.
  double half_length = 0, half_width = 0;
};

/// The city at one time: what beams meet, and the truth for tests.
///
/// Frame:   the city's. Units: metres; seconds from the start of a drive, any value.
/// Ownership: borrows the city.
/// Threads: unchanging once made; safe to share.
class Instant {
 public:
  /// A surface that a beam meets, t metres from its origin; kNoHit where it meets none.
  struct Sight {
    double t = kNoHit;
    Material material = Material::kAsphalt;
    Rgb colour;
    bool moves = false;
  };
  /// The surface next to a point: the distance is negative within what is solid, where it is that
  /// of one of the bodies that overlap there, no longer than the true one.
  struct Nearest {
    double distance = kNoHit;  ///< kNoHit: none within the limit.
    Material material = Material::kAsphalt;
    bool moves = false;
  };

  Instant(const City& city, double seconds, const std::optional<KeptClear>& clear = std::nullopt);

  Sight look(const Beam& beam, double max_range) const;
  /// Looks for surfaces up to `limit` away; time grows with its square.
  Nearest nearest(const Eigen::Vector3d& p_city, double limit) const;

  /// Vehicles that drive, and those that stand only for a while and stand now.
  const std::vector<Vehicle>& vehicles() const { return vehicles_; }
  /// The bodies of vehicles().
  const SolidGrid& moving() const { return moving_; }

 private:
  const City& city_;
  std::vector<Vehicle> vehicles_;
  SolidGrid moving_;
};

}  // namespace voxatlas
