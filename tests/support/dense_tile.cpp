#include "support/dense_tile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace voxatlas::test {
namespace {

/// Calls visit({x, y, z}) for each voxel of a cell, from its own bit-by-bit reading of the code.
template <class Visit>
void each_voxel(CellKey cell, Visit visit) {
  const std::uint32_t edge = 128u >> cell.depth;
  Index3 low{};
  for (std::uint32_t bit = 0; bit < cell.depth; ++bit) {
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      low[axis] |= (cell.code >> (3 * bit + axis) & 1u) << bit;
    }
  }
  for (auto& c : low) c *= edge;
  for (std::uint32_t z = low[2]; z < low[2] + edge; ++z) {
    for (std::uint32_t y = low[1]; y < low[1] + edge; ++y) {
      for (std::uint32_t x = low[0]; x < low[0] + edge; ++x) {
        if (!visit(Index3{x, y, z})) return;
      }
    }
  }
}

LogOdds clamped_sum(LogOdds before, LogOdds addend, const SensorModel& model) {
  int sum = before;
  sum += addend;
  if (sum < model.clamp_min) sum = model.clamp_min;
  if (sum > model.clamp_max) sum = model.clamp_max;
  return static_cast<LogOdds>(sum);
}

std::string text(const std::optional<CellState>& state) {
  if (!state) return "unknown";
  const Colour& colour = state->colour;
  return fmt::format("{} ({} {} {} x{})", state->log_odds, colour.mean[0], colour.mean[1],
                     colour.mean[2], colour.count);
}

std::string text(const Leaf& leaf) {
  return fmt::format("cell {}/{:#x} {}", int{leaf.cell.depth}, leaf.cell.code, text(leaf.state));
}

std::string differing_cells(const std::vector<Leaf>& own, const std::vector<Leaf>& wanted) {
  for (std::size_t i = 0; i < std::max(own.size(), wanted.size()); ++i) {
    const std::string left = i < own.size() ? text(own[i]) : "nothing";
    const std::string right = i < wanted.size() ? text(wanted[i]) : "nothing";
    if (left != right) return fmt::format("cell {} in order: {}, wanted {}", i, left, right);
  }
  return {};
}

std::string text(const TileTree::Counts& c) {
  return fmt::format("leaves {} inner {} occupied {} free {} coloured {} voxels {} {}", c.leaves,
                     c.inner, c.occupied_leaves, c.free_leaves, c.coloured_leaves,
                     c.occupied_voxels, c.free_voxels);
}

}  // namespace

DenseTile::DenseTile() : voxels_(std::size_t{kTileVoxels} * kTileVoxels * kTileVoxels) {}

void DenseTile::for_each_voxel(CellKey cell, const std::function<void(Voxel&)>& change) {
  each_voxel(cell, [&](const Index3& voxel) {
    change(at(voxel));
    return true;
  });
}

void DenseTile::hit(CellKey cell, const SensorModel& model, std::optional<Rgb> seen) {
  for_each_voxel(cell, [&](Voxel& voxel) {
    voxel.known = true;
    voxel.state.log_odds = clamped_sum(voxel.state.log_odds, model.hit, model);
    if (voxel.state.log_odds < 0) voxel.state.colour = {};
    if (voxel.state.log_odds >= 0 && seen) voxel.state.colour.add(*seen);
  });
}

void DenseTile::miss(CellKey cell, const SensorModel& model) {
  for_each_voxel(cell, [&](Voxel& voxel) {
    voxel.known = true;
    voxel.state.log_odds = clamped_sum(voxel.state.log_odds, model.miss, model);
    if (voxel.state.log_odds < 0) voxel.state.colour = {};
  });
}

void DenseTile::apply(const TileDelta& delta, const SensorModel& model) {
  delta.misses.for_each([&](CellKey cell) { miss(cell, model); });
  std::size_t next = 0;
  delta.hits.for_each([&](CellKey cell) {
    std::optional<Rgb> seen;
    if (!delta.coloured.empty() && delta.coloured.contains(cell)) seen = delta.colours.at(next++);
    hit(cell, model, seen);
  });
}

void DenseTile::set(CellKey cell, const CellState& state) {
  for_each_voxel(cell, [&](Voxel& voxel) { voxel = {true, state}; });
}

void DenseTile::erase(CellKey cell) {
  for_each_voxel(cell, [](Voxel& voxel) { voxel = {}; });
}

std::optional<CellState> DenseTile::voxel(const Index3& voxel) const {
  const Voxel& found = at(voxel);
  return found.known ? std::optional(found.state) : std::nullopt;
}

std::optional<CellState> DenseTile::cell(CellKey cell) const {
  std::optional<CellState> result;
  std::array<double, 3> sum{};
  double coloured = 0;
  each_voxel(cell, [&](const Index3& voxel) {
    const Voxel& found = at(voxel);
    if (!found.known) return true;
    if (!result) result = CellState{found.state.log_odds, {}};
    result->log_odds = std::max(result->log_odds, found.state.log_odds);
    if (found.state.colour.count == 0) return true;
    for (std::size_t i = 0; i < 3; ++i) sum[i] += found.state.colour.mean[i];
    result->colour.count = std::max(result->colour.count, found.state.colour.count);
    coloured += 1;
    return true;
  });
  for (std::size_t i = 0; coloured > 0 && i < 3; ++i) {
    result->colour.mean[i] = static_cast<std::uint16_t>(std::floor(sum[i] / coloured + 0.5));
  }
  return result;
}

std::optional<CellState> DenseTile::uniform(CellKey cell) const {
  std::optional<CellState> first;
  bool same = true;
  each_voxel(cell, [&](const Index3& voxel) {
    const Voxel& found = at(voxel);
    if (!first) first = found.state;
    return same = found.known && found.state == *first;
  });
  return same ? first : std::nullopt;
}

void DenseTile::collect(CellKey cell, int depth, std::vector<Leaf>& out,
                        std::uint64_t& inner) const {
  bool known = false;
  each_voxel(cell, [&](const Index3& voxel) { return !(known = at(voxel).known); });
  if (!known) return;
  if (const auto state = uniform(cell)) return out.push_back({cell, *state});
  ++inner;
  if (cell.depth == depth) return out.push_back({cell, *this->cell(cell)});
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const CellKey child{static_cast<std::uint8_t>(cell.depth + 1), cell.code * 8 + octant};
    collect(child, depth, out, inner);
  }
}

std::vector<Leaf> DenseTile::cells(int depth) const {
  std::vector<Leaf> result;
  std::uint64_t inner = 0;
  collect({0, 0}, depth, result, inner);
  return result;
}

TileTree::Counts DenseTile::counts() const {
  TileTree::Counts counts;
  std::vector<Leaf> leaves;
  collect({0, 0}, kDepth, leaves, counts.inner);
  counts.leaves = leaves.size();
  for (const Leaf& leaf : leaves) {
    ++(leaf.state.log_odds >= 0 ? counts.occupied_leaves : counts.free_leaves);
    if (leaf.state.colour.count > 0) ++counts.coloured_leaves;
  }
  for (const Voxel& voxel : voxels_) {
    if (voxel.known) ++(voxel.state.log_odds >= 0 ? counts.occupied_voxels : counts.free_voxels);
  }
  return counts;
}

std::string difference(const TileTree& tree, const DenseTile& dense) {
  for (std::uint32_t z = 0; z < kTileVoxels; ++z) {
    for (std::uint32_t y = 0; y < kTileVoxels; ++y) {
      for (std::uint32_t x = 0; x < kTileVoxels; ++x) {
        const auto own = tree.voxel({x, y, z}), wanted = dense.voxel({x, y, z});
        if (own == wanted) continue;
        return fmt::format("voxel {} {} {}: {}, wanted {}", x, y, z, text(own), text(wanted));
      }
    }
  }
  for (int depth = 0; depth <= kDepth; ++depth) {
    std::vector<Leaf> own;
    tree.for_each_cell(depth, [&](const Leaf& leaf) { own.push_back(leaf); });
    const std::string found = differing_cells(own, dense.cells(depth));
    if (!found.empty()) return fmt::format("cut at depth {}, {}", depth, found);
  }
  const std::string own = text(tree.counts()), wanted = text(dense.counts());
  return own == wanted ? "" : fmt::format("counts: {}, wanted {}", own, wanted);
}

}  // namespace voxatlas::test
