// What a scan from outside can cost: its bytes times a constant, whatever is in it.
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <numbers>

#include "integrate/integrator.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kRays = 2'000;
constexpr std::size_t kBytesOfRay = 12;  ///< On the wire: three floats.
constexpr double kMaxRange = 120;
const Eigen::Vector3d kPlace(4146358.4, 613973.2, 4791461.9);  ///< On borders of voxels.

/// Rays of one hostile idea, given a number below kRays.
using Idea = Eigen::Vector3d (*)(std::size_t i);

Eigen::Vector3d on_sphere(std::size_t i, double range) {
  const double up = 2 * (static_cast<double>(i) + 0.5) / kRays - 1;
  const double turn = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
  const double level = std::sqrt(1 - up * up);
  return kPlace + range * Eigen::Vector3d(level * std::cos(turn), level * std::sin(turn), up);
}

struct Hostile {
  const char* name;
  Idea end;
};

constexpr double kTiny = 5e-324, kHuge = 1.7e308;

const Hostile kIdeas[] = {
    {"a sphere at max_range", [](std::size_t i) { return on_sphere(i, kMaxRange); }},
    {"rays of 10^7 m", [](std::size_t i) { return on_sphere(i, 1e7); }},
    {"rays whose length overflows",
     [](std::size_t i) -> Eigen::Vector3d {
       return {i % 2 ? kHuge : -kHuge, kHuge, kTiny};
     }},
    {"rays along one axis, on borders",
     [](std::size_t i) -> Eigen::Vector3d {
       return kPlace + Eigen::Vector3d(i % 2 ? kMaxRange : -kMaxRange, 0, 0);
     }},
    {"diagonals through corners of voxels",
     [](std::size_t i) -> Eigen::Vector3d {
       return kPlace + (i % 2 ? 69.2 : -69.2) * Eigen::Vector3d(1, i % 4 < 2 ? 1 : -1, 1);
     }},
    {"rays that nearly run along an axis",
     [](std::size_t i) -> Eigen::Vector3d {
       return kPlace + Eigen::Vector3d(119.9, 1e-7 * static_cast<double>(i), -1e-8);
     }},
    {"no returns",
     [](std::size_t i) -> Eigen::Vector3d {
       return {std::nan(""), i % 2 ? HUGE_VAL : -HUGE_VAL, 0};
     }},
    {"points at the origin", [](std::size_t) { return kPlace; }}};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST_CASE("a hostile scan costs at most its bytes times a constant", "[integrate]") {
  // A walk of 120 m crosses at most 3 * 1200 borders. One of 10^7 m would take a second.
  constexpr double kMostSeconds = 100e-6, kMostCells = 3 * 1201.0 / kBytesOfRay;
  constexpr double kMostBytes = kMostCells * 100;  // A cell alone in its brick, in its tile.
  const int free_depth = GENERATE(7, 4, -1);
  Integrator integrator(Grid::standard(), {free_depth, 7, 0, kMaxRange});
  for (const auto& idea : kIdeas) {
    CAPTURE(idea.name, free_depth);
    Scan scan;
    scan.origin_ecef = kPlace;
    scan.sigma = 0.02;
    for (std::size_t i = 0; i < kRays; ++i) scan.endpoints_ecef.push_back(idea.end(i));
    const double bytes = kRays * kBytesOfRay;

    const double start = cpu_seconds();
    const auto delta = integrator.integrate(scan);
    const double seconds = cpu_seconds() - start;

    REQUIRE(delta.has_value());
    REQUIRE(delta->counts.rays == kRays);
    REQUIRE(seconds < bytes * kMostSeconds);
    REQUIRE(static_cast<double>(delta->counts.cells_missed + delta->counts.cells_hit) <
            bytes * kMostCells + kRays);
    Bytes encoded;
    for (const auto& [key, change] : delta->tiles) encode_delta(change, encoded);
    REQUIRE(static_cast<double>(encoded.size()) < bytes * kMostBytes);
  }
}

/// Cells that a ray passes, which is what carving it costs: in a scan of its own none counts as
/// another ray's.
std::uint64_t cells_of(Integrator& integrator, const Eigen::Vector3d& end) {
  Scan scan;
  scan.origin_ecef = kPlace;
  scan.sigma = 0.02;
  scan.endpoints_ecef = {end};
  const auto delta = integrator.integrate(scan);
  REQUIRE(delta.has_value());
  return delta->counts.cells_missed + delta->counts.cells_hit;
}

TEST_CASE("no ray passes more cells than max_range has borders, wherever it ends", "[integrate]") {
  // 120 m are at most 1201 borders on an axis; the origin's cell is one more.
  const auto [free_depth, most_cells] =
      GENERATE(table<int, std::uint64_t>({{7, 3 * 1201 + 1}, {4, 3 * 151 + 2}, {-1, 1}}));
  Integrator integrator(Grid::standard(), {free_depth, 7, 0, kMaxRange});
  for (const auto& idea : kIdeas) {
    for (std::size_t i = 0; i < kRays; i += 20) {
      CAPTURE(idea.name, i, free_depth);
      REQUIRE(cells_of(integrator, idea.end(i)) <= most_cells);
    }
  }
}

TEST_CASE("sigma is taken in (0, a quarter of a tile], and no hostile one is slow", "[integrate]") {
  Integrator integrator(Grid::standard(), {7, 7, 0, kMaxRange});
  Scan scan;
  scan.origin_ecef = kPlace;
  scan.endpoints_ecef = {on_sphere(0, 20), on_sphere(7, 1e7)};
  for (const double sigma : {0.02, 0.05, 3.2, kTiny}) {
    scan.sigma = sigma;
    REQUIRE(integrator.integrate(scan).has_value());
  }
  for (const double sigma : {0.0, -0.02, 3.2000001, kHuge, HUGE_VAL, std::nan("")}) {
    scan.sigma = sigma;
    REQUIRE(integrator.integrate(scan).error().code == ErrorCode::kOutOfRange);
  }
}

}  // namespace
}  // namespace voxatlas
