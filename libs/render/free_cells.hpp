#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grid/tile_key.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// Which cells of one depth of a tile are free: something in them is known and nothing occupied.
///
/// Source: the paper's figure 3, free space at a depth of one's own choice.
/// Units:  whole cells from the tile's lower corner, 0 .. edge() - 1 on each axis.
/// Threads: never changes; safe to share. Memory: a bit a cell, 256 kB at depth 7.
class FreeCells {
 public:
  /// `depth` is 0..7.
  FreeCells(const TileTree& tree, int depth);

  int depth() const { return depth_; }
  int edge() const { return 1 << depth_; }
  bool holds(const Eigen::Vector3i& at) const {
    const std::size_t i = index(at);
    return (bits_[i / 64] >> i % 64 & 1u) != 0;
  }
  std::size_t count() const;
  std::size_t memory_bytes() const { return sizeof *this + bits_.capacity() * sizeof bits_[0]; }

 private:
  std::size_t index(const Eigen::Vector3i& at) const {
    const auto x = static_cast<std::size_t>(at.x()), y = static_cast<std::size_t>(at.y()),
               z = static_cast<std::size_t>(at.z());
    return ((z << depth_ | y) << depth_) | x;
  }

  int depth_;
  std::vector<std::uint64_t> bits_;
};

/// Places the free cells of a tile on the grid.
struct PlacedFree {
  TileKey key;
  const FreeCells* cells = nullptr;
};

/// A face between a free cell and what is not free: an axis, and the side of it that is not.
struct FreeFace {
  Eigen::Vector3i cell;
  std::uint8_t axis;
  bool upper;
};

/// The faces that bound the free space of each of several tiles of one depth, seen together: faces
/// between free cells of neighbouring tiles are none. One list a tile, in their order.
std::vector<std::vector<FreeFace>> bounding_faces(std::span<const PlacedFree> tiles);

}  // namespace voxatlas
