#pragma once

#include "base/result.hpp"

namespace voxatlas {

/// The depth at which measurements of standard deviation sigma (metres) are integrated.
///
/// Source: the paper's equation (5): d_int = min(floor(log2(l_tile / (4 sigma))), d_tile).
/// Exact at the borders: 0.025 m gives 7 in a 12.8 m tile, the next larger double gives 6.
/// Errors: kOutOfRange for sigma <= 0, NaN, infinite, or so large that the depth would be negative.
Result<int> integration_depth(double sigma, double tile_length);

}  // namespace voxatlas
