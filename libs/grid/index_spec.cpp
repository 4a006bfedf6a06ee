#include "grid/index_spec.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace voxatlas {
namespace {

constexpr double kEarthDiameter = 12.8e6;
constexpr int kMaxTileDepth = 30;
constexpr double kMaxCountable = 9007199254740992.0;  // 2^53: above it doubles skip whole numbers.

/// ceil(log2(q)) for q >= 1, exact where q is a power of two, as the exponent is read, not
/// computed.
int ceil_log2(double q) {
  int exponent = 0;
  const double mantissa = std::frexp(q, &exponent);  // q = mantissa * 2^exponent, [0.5, 1).
  return mantissa == 0.5 ? exponent - 1 : exponent;
}

/// ceil(q), but a q that only rounding keeps from a whole number is that number: l_tile = 128 / 3
/// is not a double, and 300 000 tiles of it must not become 300 001.
double ceil_whole(double q) {
  const double nearest = std::round(q);
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * q;
  return std::abs(q - nearest) <= rounding ? nearest : std::ceil(q);
}

}  // namespace

double edge_length(double r, int d) { return std::ldexp(r, d); }

Result<IndexSpec> index_spec(double r_tile, double r_max) {
  if (!std::isfinite(r_max) || r_max <= 0) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("r_max = {} m is not a positive length", r_max));
  }
  if (!std::isfinite(r_tile) || r_tile < r_max) {
    return fail(
        ErrorCode::kOutOfRange,
        fmt::format("r_tile = {} m is not a length of r_max = {} m or more", r_tile, r_max));
  }
  const double cells = r_tile / r_max;
  const int d_tile = std::isfinite(cells) ? ceil_log2(cells) : kMaxTileDepth + 1;
  if (d_tile > kMaxTileDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("r_tile = {} m over r_max = {} m needs a d_tile above {}", r_tile,
                            r_max, kMaxTileDepth));
  }
  const double l_tile = edge_length(r_max, d_tile);
  const double tiles = ceil_whole(kEarthDiameter / l_tile);
  if (!std::isfinite(l_tile) || tiles > kMaxCountable) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("l_tile = {} m does not tile the Earth in countable tiles", l_tile));
  }
  return IndexSpec{.d_tile = d_tile, .l_tile = l_tile, .l_index = tiles * l_tile};
}

}  // namespace voxatlas
