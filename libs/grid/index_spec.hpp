#pragma once

#include "base/result.hpp"

namespace voxatlas {

/// The sizes that follow from the two numbers a user wishes for.
///
/// Source: the paper's section 3.3, equations (1)-(4).
/// Units:  metres, but for d_tile (levels below a tile's root).
struct IndexSpec {
  int d_tile;      ///< eq. (2): ceil(log2(r_tile / r_max)).
  double l_tile;   ///< eq. (3): r_max * 2^d_tile.
  double l_index;  ///< eq. (4): the Earth's 12 800 km, rounded up to whole tiles.
};

/// Errors: kOutOfRange where r_max or r_tile is not finite, not positive, or r_tile < r_max, or
///         where d_tile would exceed 30, or an axis 2^53 tiles.
Result<IndexSpec> index_spec(double r_tile, double r_max);

/// Eq. (1): edge length of a cube whose cells at depth d are r wide: r * 2^d.
double edge_length(double r, int d);

}  // namespace voxatlas
