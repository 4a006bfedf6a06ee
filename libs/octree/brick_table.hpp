#pragma once

#include <array>
#include <optional>
#include <unordered_map>

#include "octree/brick_colours.hpp"
#include "octree/brick_pool.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// Bricks first, first + 1, ...: those of one cell of depth 0..4, as bricks are numbered in Morton
/// order.
struct BrickRange {
  unsigned first = 0, count = 1;

  static BrickRange of(CellKey cell) {
    const int shift = 3 * (kBrickDepth - cell.depth);
    return {cell.code << shift, 1u << shift};
  }
};

/// The 4096 brick slots of a tile: what stands in each, and where.
///
/// Layout:    a slot is empty, uniform or mixed (two bits in two planes) and has 16 more bits: a
///            uniform slot's log-odds, a mixed slot's place in the pool. Colours are found by
///            brick number, behind a plane that says who has any.
/// Invariant: between updates (after settle()) a mixed slot is neither uniform nor empty, so that
///            equal functions have equal slots.
class BrickTable {
 public:
  using Plane = std::array<std::uint64_t, kBricks / 64>;  ///< A bit a brick.

  bool is_empty(unsigned brick) const { return !bit(known_, brick); }
  bool is_mixed(unsigned brick) const { return bit(mixed_, brick); }
  bool is_uniform(unsigned brick) const { return !is_empty(brick) && !is_mixed(brick); }

  LogOdds uniform_log_odds(unsigned brick) const { return static_cast<LogOdds>(slots_[brick]); }
  CellState uniform_state(unsigned brick) const;
  const Brick& mixed(unsigned brick) const { return pool_[slots_[brick]]; }
  Brick& mixed(unsigned brick) { return pool_[slots_[brick]]; }
  bool has_colours() const { return !colours_.empty(); }
  /// nullptr where the brick has no colour.
  const BrickColours* colours(unsigned brick) const;

  void make_empty(unsigned brick);
  void make_uniform(unsigned brick, const CellState& state);
  void make_uniform(BrickRange range, const CellState& state);  ///< Each of them.
  /// Changes a uniform slot's log-odds and leaves its colour.
  void set_uniform_log_odds(unsigned brick, LogOdds log_odds);
  /// The slot as a mixed one, of the same function, for the caller to change and then settle().
  Brick& expand(unsigned brick);
  BrickColours& colours_of(unsigned brick);  ///< Made, empty, where there were none.
  /// After a change of a mixed slot or its colours: restores the invariant.
  void settle(unsigned brick);

  /// Nothing known in any of these bricks.
  bool is_empty(BrickRange range) const;
  /// The state that all voxels of these bricks share, if they do.
  std::optional<CellState> uniform(BrickRange range) const;

  bool is_empty() const;
  /// The uniform bricks that are occupied, and all mixed ones.
  Plane maybe_occupied() const;
  void compact();  ///< Gives back unused bricks where there are many.
  std::size_t memory_bytes() const;

  friend bool operator==(const BrickTable& a, const BrickTable& b);

 private:
  static bool bit(const Plane& plane, unsigned i) { return (plane[i / 64] >> i % 64 & 1) != 0; }
  static void set_bit(Plane& plane, unsigned i, bool value) {
    const std::uint64_t mask = std::uint64_t{1} << i % 64;
    plane[i / 64] = value ? plane[i / 64] | mask : plane[i / 64] & ~mask;
  }
  void drop_brick(unsigned brick);
  void drop_colours(unsigned brick);

  Plane known_{}, mixed_{}, coloured_{};
  std::array<std::uint16_t, kBricks> slots_{};
  BrickPool pool_;
  std::unordered_map<unsigned, BrickColours> colours_;
};

}  // namespace voxatlas
