// The paper's section 3.3: what its equations give for the standard parametrisation and five
// others.
//
// Prints lines `r_tile/r_max/what value unit`.
#include <fmt/format.h>

#include "grid/index_spec.hpp"

int main() {
  constexpr double kWishes[][2] = {{10, 0.1}, {10, 0.05}, {10, 0.2},
                                   {50, 0.1}, {5, 0.1},   {15, 0.07}};
  for (const auto& [r_tile, r_max] : kWishes) {
    const auto spec = voxatlas::index_spec(r_tile, r_max);
    if (!spec) {
      fmt::print(stderr, "bench_index: {}\n", spec.error().message);
      return 1;
    }
    const auto name = fmt::format("{}/{}", r_tile, r_max);
    fmt::print("{0}/d_tile {1} levels\n{0}/l_tile {2} m\n{0}/l_index {3} m\n", name, spec->d_tile,
               spec->l_tile, spec->l_index);
    fmt::print("{}/eq1 {} m\n", name, voxatlas::edge_length(r_max, spec->d_tile));
  }
}
