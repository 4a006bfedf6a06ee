#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "grid/cell_key.hpp"

namespace voxatlas {

/// Which cells of one depth of a tile are occupied, a bit each; coarser leaves fill all cells they
/// cover. Beyond the tile nothing is known: there, a cell counts as not occupied.
class OccupiedCells {
 public:
  explicit OccupiedCells(int depth);

  void insert(CellKey cell);

  /// True where every cell that touches a face of `cell` is occupied.
  bool surround(CellKey cell) const;

  /// The normal of the plane that fits the 5 x 5 x 5 cells around one best, of length 1, either
  /// way round; zero for coarser leaves and where fewer than kFewest of those are occupied.
  Eigen::Vector3f normal(CellKey cell) const;
  static constexpr int kFewest = 5;

 private:
  struct Place {
    Index3 min;
    std::uint32_t size;
  };

  Place place(CellKey cell) const;
  std::size_t index(const Index3& at) const {
    return (std::size_t{at[2]} * edge_ + at[1]) * edge_ + at[0];
  }
  bool holds(const Index3& at) const {
    const std::size_t i = index(at);
    return (bits_[i / 64] >> i % 64 & 1u) != 0;
  }
  /// The square of cells beside a face: `layer` on `axis`, the cell's own extent on the others.
  bool layer_full(const Place& cell, std::size_t axis, std::uint32_t layer) const;
  /// The five cells (x - 2 .. x + 2, y, z), lowest bit first.
  unsigned row_of_five(int x, int y, int z) const;

  int shift_;
  std::uint32_t edge_;
  std::vector<std::uint64_t> bits_;  // And a word more, so that any bit can be read with 64.
};

}  // namespace voxatlas
