#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/result.hpp"
#include "grid/morton.hpp"

namespace voxatlas {

/// The address of a tile: the Morton code of its place among the tiles of the grid.
///
/// Source:  the paper's section 3.2.
/// Units:   tiles, counted from the lower corner of the index cube, for index().
/// Errors:  the factories return kOutOfRange for an axis of 2^21 or more and a code of 2^63 or
///          more. Whether a key lies on a certain grid (10^6 tiles an axis at 10 cm) is the Grid's
///          to say.
/// Cost:    8 bytes, copied by value.
class TileKey {
 public:
  static constexpr unsigned kBitsPerAxis = 21;

  [[nodiscard]] static Result<TileKey> from_morton(std::uint64_t code);
  [[nodiscard]] static Result<TileKey> from_index(const Index3& index);

  std::uint64_t morton() const { return code_; }
  Index3 index() const { return morton_decode(code_); }

  friend auto operator<=>(TileKey, TileKey) = default;

 private:
  friend class Grid;  // Its voxels are checked once; their keys need no second check.
  explicit TileKey(std::uint64_t code) : code_(code) {}

  std::uint64_t code_;
};

}  // namespace voxatlas

template <>
struct std::hash<voxatlas::TileKey> {
  std::size_t operator()(voxatlas::TileKey key) const noexcept {
    std::uint64_t x = key.morton() + 0x9e3779b97f4a7c15u;  // splitmix64: Morton codes are dense.
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
  }
};
