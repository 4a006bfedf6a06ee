#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "grid/cell_key.hpp"
#include "grid/morton.hpp"
#include "octree/colour.hpp"
#include "octree/log_odds.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {

class BrickTable;

/// What is known of a voxel, a leaf or an inner cell.
struct CellState {
  LogOdds log_odds = 0;
  Colour colour;  ///< exists() only where log_odds >= 0.

  friend bool operator==(const CellState&, const CellState&) = default;
};

/// A leaf of the canonical octree: the largest cells that are uniform; never unknown.
struct Leaf {
  CellKey cell;
  CellState state;

  friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// What one tile knows: a function from its 128^3 voxels to unknown, or log-odds and colour.
///
/// Source:  the paper's sections 3.2 and 4; DESIGN section 3. An update at depth d is the same
/// update
///          on each of its 8^(7-d) voxels, unknown counting as 0, each clamped. The octree is the
///          canonical pruned form of the function: a cell is a leaf where all its voxels are known
///          and equal (log-odds and colour) and its parent is not such a cell.
/// Layout:  4096 brick slots in Morton order, each empty, one uniform state, or a brick of 512
///          log-odds [z][y][x] with a known mask; colour beside it, only where colour came.
/// Threads: const calls from any number of threads; others one at a time, alone.
/// Cost:    about 1.1 kB a mixed brick and 8 bytes a coloured voxel of it, 10 kB a tile at least
/// once
///          anything is known.
class TileTree {
 public:
  TileTree();
  ~TileTree();
  TileTree(const TileTree& other);
  TileTree& operator=(const TileTree& other);
  TileTree(TileTree&&) noexcept;
  TileTree& operator=(TileTree&&) noexcept;

  /// Adds `model.hit` or `model.miss` to every voxel of one cell; a hit may bring a colour.
  /// A colour is dropped where the log-odds fall below 0.
  void hit(CellKey cell, const SensorModel& model, std::optional<Rgb> seen = std::nullopt);
  void miss(CellKey cell, const SensorModel& model);

  /// Misses, then hits, then colours: the same as hit() and miss() for every cell of the delta.
  void apply(const TileDelta& delta, const SensorModel& model);

  /// Sets every voxel of a cell, as decoders and converters do. A colour with log-odds < 0 is a
  /// bug.
  void set(CellKey cell, const CellState& state);
  /// Makes every voxel of a cell unknown.
  void erase(CellKey cell);

  bool empty() const;
  /// nullopt where unknown. Each coordinate 0..127.
  std::optional<CellState> voxel(const Index3& voxel) const;
  /// A cell at any depth: the maximum log-odds of its known voxels and the mean of its coloured
  /// ones (count: the largest); nullopt where none is known. Inner cells are computed, never
  /// stored.
  std::optional<CellState> cell(CellKey cell) const;
  /// The state all voxels of the cell share, nullopt where they differ or any is unknown.
  std::optional<CellState> uniform(CellKey cell) const;

  /// Every leaf of the canonical octree, in Morton order (children 0..7, depth first).
  void for_each_leaf(const std::function<void(const Leaf&)>& visit) const;
  std::vector<Leaf> leaves() const;

  /// The cells of the canonical octree cut at `depth`: leaves above it as they are, and at `depth`
  /// every cell that knows anything, inner ones as cell() gives them. For drawing at a depth.
  void for_each_cell(int depth, const std::function<void(const Leaf&)>& visit) const;

  struct Counts {
    std::uint64_t leaves = 0, inner = 0;  ///< Nodes of the canonical octree.
    std::uint64_t occupied_leaves = 0, free_leaves = 0, coloured_leaves = 0;
    std::uint64_t occupied_voxels = 0, free_voxels = 0;  ///< The same function counted at depth 7.
  };
  Counts counts() const;

  /// Gives unused memory back where there is much of it. Changes no voxel.
  void prune();

  /// Bytes held, this object included.
  std::size_t memory_bytes() const;

  /// The bricks behind the tile, for codecs, which would be slow leaf by leaf. nullptr: it has
  /// none.
  const BrickTable* bricks() const;
  /// A tile of these bricks, which are settled.
  static TileTree of_bricks(BrickTable&& bricks);

  /// Equal as functions of voxels, whatever their layout.
  friend bool operator==(const TileTree& a, const TileTree& b);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
