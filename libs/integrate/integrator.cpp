#include "integrate/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "integrate/carve.hpp"
#include "integrate/colour_means.hpp"
#include "integrate/fold.hpp"
#include "integrate/free_rays.hpp"
#include "integrate/marks.hpp"
#include "integrate/quality.hpp"
#include "integrate/ray_order.hpp"

namespace voxatlas {
namespace {

/// What is to be done with one endpoint.
struct Ray {
  enum Kind { kHit, kBeyondMax, kBelowMin, kNotFinite, kOffCube } kind;
  Eigen::Vector3d end_ecef;  ///< Cut at max_range; set for the first two kinds.
  VoxelIndex end_voxel;      ///< Of `end_ecef`.
};

/// Written out, so that the order of the additions, and with it the last bit, does not depend on
/// how a compiler or a processor likes to sum.
double length_of(const Eigen::Vector3d& v) {
  return std::sqrt(v.x() * v.x() + v.y() * v.y() + v.z() * v.z());
}

/// A point `range` metres from the origin towards `end`. Scaled first, as a hostile endpoint's
/// squares may overflow.
Eigen::Vector3d cut(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, double range) {
  Eigen::Vector3d towards = end - origin;
  towards /= towards.cwiseAbs().maxCoeff();
  return origin + towards * (range / length_of(towards));
}

Ray classify(const Grid& grid, const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
             double min_range, double max_range) {
  if (!end.allFinite()) return {Ray::kNotFinite, {}, {}};
  const double length = length_of(end - origin);  // Infinite where squares overflow: beyond max.
  if (length < min_range) return {Ray::kBelowMin, {}, {}};
  Ray ray{length > max_range ? Ray::kBeyondMax : Ray::kHit, end, {}};
  if (ray.kind == Ray::kBeyondMax) ray.end_ecef = cut(origin, end, max_range);
  ray.end_voxel = grid.voxel_unchecked(ray.end_ecef);
  if (!grid.holds(ray.end_voxel)) ray.kind = Ray::kOffCube;
  return ray;
}

/// Says of most endpoints, and of hits alone, that they are hits, without a root and without a look
/// at the cube: their squared length is within the ranges whichever way it was rounded, and the
/// scan is far from the cube's faces.
class SureHits {
 public:
  SureHits(const Grid& grid, const Eigen::Vector3d& origin, double min_range, double max_range)
      : origin_(origin), least_(min_range * min_range * (1 + kRounding)) {
    const auto reach = Eigen::Vector3d::Constant(max_range + 1);
    const bool far = grid.voxel_at(origin - reach) && grid.voxel_at(origin + reach);
    most_ = far ? max_range * max_range * (1 - kRounding) : 0;
  }

  bool has(const Eigen::Vector3d& end) const {
    const double x = end.x() - origin_.x(), y = end.y() - origin_.y(), z = end.z() - origin_.z();
    const double squared = x * x + y * y + z * z;  // NaN, infinity: no.
    return squared > least_ && squared < most_;
  }

 private:
  static constexpr double kRounding = 1e-9;

  Eigen::Vector3d origin_;
  double least_, most_;
};

void count(IntegrationCounts& counts, Ray::Kind kind) {
  ++counts.rays;
  counts.hits += kind == Ray::kHit;
  counts.beyond_max += kind == Ray::kBeyondMax;
  counts.below_min += kind == Ray::kBelowMin;
  counts.not_finite += kind == Ray::kNotFinite;
  counts.off_cube += kind == Ray::kOffCube;
}

Status check_scan(const Scan& scan) {
  if (!(scan.min_range >= 0)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("scan's min_range {} m is negative", scan.min_range));
  }
  if (!scan.colours.empty() && scan.colours.size() != scan.endpoints_ecef.size()) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("scan has {} colours for {} endpoints", scan.colours.size(),
                            scan.endpoints_ecef.size()));
  }
  return {};
}

}  // namespace

struct Integrator::State {
  Grid grid;
  IntegrationParameters parameters;
  Marks carved;  ///< The misses where they are coarse, in cells as if those were voxels.
  Marks misses, hits;
  ColourMeans colours;
  std::vector<ColourMeans::Seen> seen;
  std::vector<Eigen::Vector3d> free_ends;  ///< Of the rays to carve, in voxels.
  RayOrder order;

  void reset(int depth);
  /// Marks every cell of the scan's rays.
  IntegrationCounts mark(const Scan& scan);
};

void Integrator::State::reset(int depth) {
  // A scan's cells are at most max_range from its origin.
  const auto reach =
      static_cast<std::uint32_t>(std::ceil(2 * parameters.max_range / grid.tile_length())) + 1;
  carved.reset(kDepth, reach);
  misses.reset(std::clamp(parameters.free_depth, 0, depth), reach);
  hits.reset(std::min(parameters.surface_depth, depth), reach);
  colours.clear();
  seen.clear();
  free_ends.clear();
}

IntegrationCounts Integrator::State::mark(const Scan& scan) {
  IntegrationCounts counts;
  const Eigen::Vector3d origin = grid.to_voxels(scan.origin_ecef);
  const double min_range = std::max(parameters.min_range, scan.min_range);
  const bool carves = parameters.free_depth != IntegrationParameters::kNoFreeSpace;
  const int hit_shift = kDepth - hits.depth();
  const double scale = std::ldexp(1.0, misses.depth() - kDepth);
  Marks& rays = scale == 1 ? misses : carved;
  const auto hit = [&](const VoxelIndex& voxel, std::size_t i) {
    const auto place =
        hit_shift == 0
            ? set_voxel_mark(hits, voxel.x(), voxel.y(), voxel.z())
            : set_mark(hits, VoxelIndex(voxel.unaryExpr([&](int at) { return at >> hit_shift; })));
    if (!scan.colours.empty()) seen.push_back({place, scan.colours[i]});
  };
  const int coarser = parameters.all_rays_free ? 0 : std::max(0, hits.depth() - misses.depth());
  const FreeRays free_rays(scan.utime, coarser);
  const auto miss = [&](const Eigen::Vector3d& endpoint_ecef, const Eigen::Vector3d& end_ecef) {
    if (!carves || !free_rays.has(endpoint_ecef)) return;
    free_ends.push_back(grid.to_voxels(end_ecef));
  };
  const SureHits sure(grid, scan.origin_ecef, min_range, parameters.max_range);
  for (std::size_t i = 0; i < scan.endpoints_ecef.size(); ++i) {
    const Eigen::Vector3d& end_ecef = scan.endpoints_ecef[i];
    if (sure.has(end_ecef)) {
      hit(grid.voxel_unchecked(end_ecef), i);
      miss(end_ecef, end_ecef);
      count(counts, Ray::kHit);
      continue;
    }
    const auto ray = classify(grid, scan.origin_ecef, end_ecef, min_range, parameters.max_range);
    count(counts, ray.kind);
    if (ray.kind == Ray::kHit) hit(ray.end_voxel, i);
    if (ray.kind == Ray::kHit || ray.kind == Ray::kBeyondMax) miss(end_ecef, ray.end_ecef);
  }
  // Coarse cells have so few bricks that they are in the cache in any order.
  if (scale == 1) order.sort(origin, free_ends);
  for (const auto& end : free_ends) carve(origin * scale, end * scale, rays);
  rays.merge();
  if (scale != 1) add_cells(carved, misses);
  return counts;
}

Integrator::Integrator(const Grid& grid, const IntegrationParameters& parameters)
    : state_(new State{grid, parameters, {}, {}, {}, {}, {}, {}, {}}) {
  VOX_CHECK(parameters.check().has_value());
}

Integrator::~Integrator() = default;

Result<ScanDelta> Integrator::integrate(const Scan& scan) {
  auto depth = integration_depth(scan.sigma, state_->grid.tile_length());
  if (!depth) return pass_on(depth);
  auto usable = check_scan(scan);
  if (!usable) return pass_on(usable);
  auto on_cube = state_->grid.voxel_at(scan.origin_ecef);
  if (!on_cube) return pass_on(on_cube, "scan's origin");

  state_->reset(*depth);
  const auto counts = state_->mark(scan);
  if (!state_->seen.empty()) state_->colours.sum(state_->hits, state_->seen);
  auto delta = fold(state_->misses, state_->hits, state_->colours);
  delta.counts += counts;
  return delta;
}

}  // namespace voxatlas
