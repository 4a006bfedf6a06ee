#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/cell_key.hpp"

namespace voxatlas {

/// Which cells of one depth of a tile are occupied, a bit each, and of the tiles around it those
/// within kMargin of its faces; coarser leaves fill all cells they cover. Farther off nothing is
/// known: there, a cell counts as not occupied.
///
/// Places: whole cells from the tile's lower corner, -kMargin .. edge + kMargin - 1 on each axis.
class OccupiedCells {
 public:
  static constexpr int kMargin = 2;
  /// A normal is made of so many cells or more.
  static constexpr int kFewest = 5;

  explicit OccupiedCells(int depth);

  /// Cells along the tile's edge.
  int edge() const { return edge_; }

  /// A cell, no farther off than kMargin.
  void insert(const Eigen::Vector3i& at) {
    const auto bit = static_cast<std::size_t>(at.x() + kMargin);
    bits_[row(at.y(), at.z()) + bit / 64] |= std::uint64_t{1} << bit % 64;
  }
  /// Those of eight cells that are in `octants`: children of one cell, `at` is octant 0's place, or
  /// of a tile the tile itself. As holds_of, no farther off than kMargin.
  void insert(const Eigen::Vector3i& at, std::uint32_t octants) {
    for_each_pair(at, [&](std::size_t word, std::size_t bit, int shift) {
      bits_[word] |= std::uint64_t{octants >> shift & 3} << bit;
    });
  }
  /// Which of the eight are held.
  std::uint32_t holds_of(const Eigen::Vector3i& at) const {
    std::uint32_t octants = 0;
    for_each_pair(at, [&](std::size_t word, std::size_t bit, int shift) {
      octants |= static_cast<std::uint32_t>(bits_[word] >> bit & 3) << shift;
    });
    return octants;
  }
  /// A cube of cells, of which some may lie farther off.
  void insert(const Eigen::Vector3i& min, int size);
  void insert(CellKey cell) { insert(place(cell).min, place(cell).size); }

  bool holds(const Eigen::Vector3i& at) const {
    const auto bit = static_cast<std::size_t>(at.x() + kMargin);
    return (bits_[row(at.y(), at.z()) + bit / 64] >> bit % 64 & 1u) != 0;
  }

  /// True where every cell that touches a face of `cell` is occupied.
  bool surround(CellKey cell) const;

  /// Of at most kAtOnce cells, each one of the tile's own: the normal of the plane that fits the
  /// 5 x 5 x 5 cells around it best, of length 1, either way round; zero where fewer than kFewest
  /// of those are occupied. The same bits whichever cells are asked for together.
  void normals(std::span<const Eigen::Vector3i> at, Eigen::Vector3f* found) const;
  static constexpr std::size_t kAtOnce = 8;
  /// Of one; zero for coarser leaves.
  Eigen::Vector3f normal(CellKey cell) const;

 private:
  struct Place {
    Eigen::Vector3i min;
    int size;
  };

  Place place(CellKey cell) const;
  /// Two cells on x are always in one word, where the first has an even place or is the tile.
  template <class Visit>
  void for_each_pair(const Eigen::Vector3i& at, const Visit& visit) const {
    const auto bit = static_cast<std::size_t>(at.x() + kMargin);
    for (int pair = 0; pair < 4; ++pair) {
      visit(row(at.y() + (pair & 1), at.z() + (pair >> 1)) + bit / 64, bit % 64, 2 * pair);
    }
  }
  /// The words of the row through (y, z), whose bit 0 is x = -kMargin.
  std::size_t row(int y, int z) const {
    return (static_cast<std::size_t>(z + kMargin) * static_cast<std::size_t>(edge_ + 2 * kMargin) +
            static_cast<std::size_t>(y + kMargin)) *
           words_;
  }
  /// The square of cells beside a face: `layer` on `axis`, the cell's own extent on the others.
  bool layer_full(const Place& cell, int axis, int layer) const;
  /// Over the occupied of the 5 x 5 x 5 cells around one, at -2 .. 2: how many, x, y and z, and
  /// their products xx, xy, xz, yy, yz, zz.
  struct Sums {
    int count;
    std::array<int, 3> first;
    std::array<int, 6> second;
  };
  Sums sums_around(const Eigen::Vector3i& at) const;

  int shift_;
  int edge_;
  std::size_t words_;                // A row's.
  std::vector<std::uint64_t> bits_;  // And a word more, so that any bit can be read with 64.
};

}  // namespace voxatlas
