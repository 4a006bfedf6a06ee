#include "atlas/tile_merge.hpp"

#include <algorithm>

namespace voxatlas {
namespace {

Colour merged(const Colour& a, const Colour& b) {
  if (!a.exists()) return b;
  if (!b.exists()) return a;
  const unsigned count = unsigned{a.count} + b.count;
  Colour sum;
  for (std::size_t i = 0; i < sum.mean.size(); ++i) {
    const unsigned weighted = unsigned{a.mean[i]} * a.count + unsigned{b.mean[i]} * b.count;
    sum.mean[i] = static_cast<std::uint16_t>((weighted + count / 2) / count);
  }
  sum.count = static_cast<std::uint16_t>(std::min<unsigned>(count, Colour::kMaxCount));
  return sum;
}

CellState merged(const CellState& a, const CellState& b, const SensorModel& model) {
  CellState sum{model.update(a.log_odds, b.log_odds), {}};
  if (is_occupied(sum.log_odds)) sum.colour = merged(a.colour, b.colour);
  return sum;
}

/// One state for the whole cell: set where nothing is known, added where all is equal, else in
/// parts.
void add(TileTree& tile, CellKey cell, const CellState& state, const SensorModel& model) {
  if (const auto known = tile.uniform(cell)) {
    tile.set(cell, merged(*known, state, model));
  } else if (!tile.cell(cell)) {
    tile.set(cell, state);
  } else {
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      add(tile, cell.child(octant), state, model);
    }
  }
}

}  // namespace

void merge_tile(TileTree& tile, const TileTree& other, const SensorModel& model) {
  other.for_each_leaf([&](const Leaf& leaf) { add(tile, leaf.cell, leaf.state, model); });
  tile.prune();
}

}  // namespace voxatlas
