#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "render/cell_cloud.hpp"

namespace voxatlas {

/// What a backend draws, before any colour: which cell each pixel shows, and how far it is.
///
/// Order: row by row from the upper left.
struct CellImage {
  static constexpr std::uint32_t kNone = 0;
  static constexpr float kNowhere = std::numeric_limits<float>::infinity();

  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> cell;  ///< Number of the cell, from 1 (CellNumbers); kNone: sky.
  std::vector<float> z;             ///< Metres along the camera's axis; kNowhere for sky.

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// Numbers the cells of many clouds through, from 1, in the order given: so that 32 bits of colour
/// say which cell a pixel shows.
///
/// Ownership: borrows the clouds.
class CellNumbers {
 public:
  explicit CellNumbers(std::span<const PlacedCloud> clouds);

  struct Found {
    std::size_t cloud;  ///< Which of the clouds,
    std::size_t cell;   ///< which of its cells.
  };
  /// `number` is 1 .. count().
  Found find(std::uint32_t number) const;
  std::uint32_t first_of(std::size_t cloud) const { return first_[cloud]; }
  std::uint64_t count() const { return count_; }
  bool fits() const { return count_ < std::numeric_limits<std::uint32_t>::max(); }

  const DrawnCell& cell(const Found& found) const {
    return clouds_[found.cloud].cloud->cells()[found.cell];
  }
  const PlacedCloud& cloud(const Found& found) const { return clouds_[found.cloud]; }

 private:
  std::span<const PlacedCloud> clouds_;
  std::vector<std::uint32_t> first_;  // Number of each cloud's first cell.
  std::uint64_t count_ = 0;
};

}  // namespace voxatlas
