#include "integrate/quality.hpp"

#include <fmt/format.h>

#include <cmath>

#include "grid/cell_key.hpp"

namespace voxatlas {

Result<int> integration_depth(double sigma, double tile_length) {
  if (sigma > 0) {
    // floor(log2(l / (4 sigma))) >= d  <=>  sigma * 2^(d + 2) <= l. Scaling by a power of two
    // rounds nothing, so each border is met exactly, which log2 and a division would not promise.
    for (int depth = kDepth; depth >= 0; --depth) {
      if (std::ldexp(sigma, depth + 2) <= tile_length) return depth;
    }
  }
  return fail(ErrorCode::kOutOfRange,
              fmt::format("scan's standard deviation {} m is not in (0, {}] m, a quarter of a tile",
                          sigma, tile_length / 4));
}

}  // namespace voxatlas
