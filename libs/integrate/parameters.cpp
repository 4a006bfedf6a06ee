#include <fmt/format.h>

#include "integrate/integrator.hpp"

namespace voxatlas {

Status IntegrationParameters::check() const {
  if (free_depth < kNoFreeSpace || free_depth > kDepth) {
    return fail(ErrorCode::kOutOfRange, fmt::format("free_depth {} is not 0..{}, nor {} for none",
                                                    free_depth, kDepth, kNoFreeSpace));
  }
  if (surface_depth < 0 || surface_depth > kDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("surface_depth {} is not 0..{}", surface_depth, kDepth));
  }
  if (!(min_range >= 0)) {  // NaN fails every comparison: so each test states what must hold.
    return fail(ErrorCode::kOutOfRange, fmt::format("min_range {} m is negative", min_range));
  }
  if (!(max_range > min_range && max_range <= kLongestRange)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("max_range {} m is not above min_range {} m and at most {} m",
                            max_range, min_range, kLongestRange));
  }
  return {};
}

IntegrationCounts& IntegrationCounts::operator+=(const IntegrationCounts& other) {
  rays += other.rays;
  hits += other.hits;
  beyond_max += other.beyond_max;
  below_min += other.below_min;
  not_finite += other.not_finite;
  off_cube += other.off_cube;
  cells_missed += other.cells_missed;
  cells_hit += other.cells_hit;
  return *this;
}

}  // namespace voxatlas
