#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "integrate/marks.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

/// The mean colour of each hit cell's points, over one scan.
///
/// Rounded to nearest, halves up, in integers, so that it does not depend on the points' order.
/// Cost: a count of bits a point, 32 bytes a cell: no hash, as the marks already number the cells.
class ColourMeans {
 public:
  /// A point that hit: where its cell's mark is, and its colour.
  struct Seen {
    MarkPlace place;
    Rgb colour;
  };

  /// Starts a scan without colours.
  void clear();
  /// Sums up; every place's bit is set in `hits`, to which no mark is added from here on.
  void sum(const Marks& hits, std::span<const Seen> seen);

  bool any() const { return !sums_.empty(); }
  /// Adds the means of a tile's hit cells to `out`, in the order of CellSet::for_each.
  void append(const Marks& hits, std::uint32_t tile, std::vector<Rgb>& out) const;

 private:
  struct Sum {
    std::uint64_t r = 0, g = 0, b = 0, points = 0;
  };
  Rgb mean(std::size_t rank) const;

  std::vector<std::uint32_t> first_ranks_;  ///< Of the first mark in each word of each block.
  std::vector<Sum> sums_;                   ///< By rank: block, word, bit.
};

}  // namespace voxatlas
