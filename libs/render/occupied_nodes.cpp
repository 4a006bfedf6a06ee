#include "render/occupied_nodes.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

using Nodes = std::array<NodesOfDepth, kDepth + 1>;

/// What is occupied within a cell, taken together. `Number` holds the sum of as many colours as the
/// cell has voxels: of a brick's one of 32 bits does, and is divided in half the time.
template <class Number>
struct Sum {
  LogOdds highest = -1;          ///< -1: nothing is occupied.
  bool uniform = true;           ///< All voxels are known and alike: like `first`.
  Colour first;                  ///< Of any voxel; says something where uniform.
  std::uint16_t count = 0;       ///< Of the colours, the largest,
  std::uint32_t coloured = 0;    ///< how many voxels have one,
  std::array<Number, 3> mean{};  ///< and the sum of theirs.

  /// Of a uniform cell.
  static Sum of(const CellState& state, std::uint32_t voxels) {
    Sum sum{state.log_odds, true, state.colour, state.colour.count, 0, {}};
    if (!state.colour.exists()) return sum;
    sum.coloured = voxels;
    for (std::size_t i = 0; i < 3; ++i) sum.mean[i] = Number{state.colour.mean[i]} * voxels;
    return sum;
  }
  bool occupied() const { return highest >= 0; }

  /// Adds a child; the first comes to a new Sum.
  template <class ChildNumber>
  void add(const Sum<ChildNumber>& child, bool is_first) {
    uniform = child.uniform &&
              (is_first || (uniform && highest == child.highest && first == child.first));
    if (is_first) first = child.first;
    highest = std::max(highest, child.highest);
    if (child.coloured == 0) return;
    count = std::max(count, child.count);
    coloured += child.coloured;
    for (std::size_t i = 0; i < 3; ++i) mean[i] += child.mean[i];
  }
  /// As Summary::state.
  CellState state() const {
    CellState result{highest, {}};
    if (coloured == 0) return result;
    for (std::size_t i = 0; i < 3; ++i) {
      result.colour.mean[i] =
          static_cast<std::uint16_t>((2 * mean[i] + coloured) / (2 * Number{coloured}));
    }
    result.colour.count = count;
    return result;
  }
};
using CellSum = Sum<std::uint64_t>;
using SmallSum = Sum<std::uint32_t>;  // Of at most a brick.

/// The occupied voxels of a mixed brick in Morton order, in which every cell of it is a run.
struct MortonVoxels {
  std::array<std::uint64_t, 8> occupied{}, coloured{};
  std::array<LogOdds, kBrickVoxels> log_odds;       // Only of those that are occupied,
  std::array<const Colour*, kBrickVoxels> colours;  // and of those that are coloured.

  MortonVoxels(const Brick& brick, const BrickColours* own) {
    const VoxelMask free = free_among(brick, brick.known);
    for (unsigned z = 0; z < 8; ++z) {
      for (std::uint64_t left = brick.known[z] & ~free[z]; left != 0; left &= left - 1) {
        const unsigned voxel = 64 * z + static_cast<unsigned>(std::countr_zero(left));
        const unsigned at = kMortonOfVoxel[voxel];
        occupied[at / 64] |= std::uint64_t{1} << at % 64;
        log_odds[at] = brick.log_odds[voxel];
      }
    }
    if (own == nullptr) return;
    own->for_each([&](unsigned voxel, const Colour& colour) {
      const unsigned at = kMortonOfVoxel[voxel];
      coloured[at / 64] |= std::uint64_t{1} << at % 64;
      colours[at] = &colour;
    });
  }
};

/// Goes through a tile once, in Morton order. What lies below a cell that turns out to be a leaf is
/// taken back.
class Collector {
 public:
  Collector(const BrickTable& table, int max_depth)
      : table_(table), max_depth_(max_depth), bricks_(table.maybe_occupied()) {}

  CellSum visit(CellKey cell);
  Nodes take() { return std::move(nodes_); }

 private:
  CellSum brick(std::uint32_t code);
  SmallSum cell_of_64(const MortonVoxels& voxels, std::uint32_t word);
  SmallSum cell_of_8(const MortonVoxels& voxels, std::uint32_t byte);
  /// A node, after those below it; `octants` are its children. Where it is uniform it is a leaf:
  /// then these are taken back, the eight nodes that were last added to the next depth.
  template <class Number>
  void add(int depth, std::uint32_t octants, const Sum<Number>& sum) {
    if (depth > max_depth_) return;
    auto& nodes = nodes_[static_cast<std::size_t>(depth)];
    nodes.paints.emplace_back(sum.state());
    if (depth == max_depth_) return;
    nodes.octants.push_back(sum.uniform ? std::uint8_t{0} : static_cast<std::uint8_t>(octants));
    if (sum.uniform && octants != 0) take_back(nodes_[static_cast<std::size_t>(depth) + 1]);
  }
  static void take_back(NodesOfDepth& leaves) {
    leaves.paints.erase(leaves.paints.end() - 8, leaves.paints.end());
    if (leaves.octants.empty()) return;
    leaves.octants.erase(leaves.octants.end() - 8, leaves.octants.end());
  }

  /// Whether any brick of a cell of depth 0..4 is to be looked at.
  bool any(CellKey cell) const {
    const BrickRange range = BrickRange::of(cell);
    if (range.count <= 64) {
      const std::uint64_t of_it = ~std::uint64_t{0} >> (64 - range.count);
      return (bricks_[range.first / 64] >> range.first % 64 & of_it) != 0;
    }
    const auto first = bricks_.begin() + range.first / 64;
    return std::any_of(first, first + range.count / 64, [](auto word) { return word != 0; });
  }

  const BrickTable& table_;
  const int max_depth_;
  const BrickTable::Plane bricks_;
  Nodes nodes_;
};

/// A cell of depth 0..4.
CellSum Collector::visit(CellKey cell) {
  if (cell.depth == kBrickDepth) return brick(cell.code);
  CellSum sum;
  std::uint32_t octants = 0;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if (!any(cell.child(octant))) continue;
    const CellSum child = visit(cell.child(octant));
    if (!child.occupied()) continue;
    sum.add(child, octants == 0);
    octants |= 1u << octant;
  }
  if (!sum.occupied()) return sum;
  sum.uniform = sum.uniform && octants == 0xff;
  add(cell.depth, octants, sum);
  return sum;
}

CellSum Collector::brick(std::uint32_t code) {
  CellSum sum;
  std::uint32_t octants = 0;
  if (table_.is_uniform(code)) {
    sum = CellSum::of(table_.uniform_state(code), kBrickVoxels);
  } else {
    const MortonVoxels voxels(table_.mixed(code), table_.colours(code));
    for (std::uint32_t word = 0; word < 8; ++word) {
      if (voxels.occupied[word] == 0) continue;
      sum.add(cell_of_64(voxels, word), octants == 0);
      octants |= 1u << word;
    }
    if (!sum.occupied()) return sum;
    sum.uniform = false;  // It would be no mixed brick.
  }
  add(kBrickDepth, octants, sum);
  return sum;
}

/// One that has something occupied, as the next.
SmallSum Collector::cell_of_64(const MortonVoxels& voxels, std::uint32_t word) {
  SmallSum sum;
  std::uint32_t octants = 0;
  for (std::uint32_t i = 0; i < 8; ++i) {
    if ((voxels.occupied[word] >> 8 * i & 0xff) == 0) continue;
    sum.add(cell_of_8(voxels, word * 8 + i), octants == 0);
    octants |= 1u << i;
  }
  sum.uniform = sum.uniform && octants == 0xff;
  add(kBrickDepth + 1, octants, sum);
  return sum;
}

SmallSum Collector::cell_of_8(const MortonVoxels& voxels, std::uint32_t byte) {
  const auto octants_in = [&](const auto& words) {
    return static_cast<std::uint32_t>(words[byte / 8] >> byte % 8 * 8 & 0xff);
  };
  const std::uint32_t octants = octants_in(voxels.occupied);
  const std::uint32_t coloured = octants_in(voxels.coloured) & octants;
  SmallSum sum;
  bool first = true;
  for (std::uint32_t left = octants; left != 0; left &= left - 1, first = false) {
    const std::uint32_t at = byte * 8 + static_cast<std::uint32_t>(std::countr_zero(left));
    const LogOdds log_odds = voxels.log_odds[at];
    const bool has_colour = (coloured & left & -left) != 0;
    const Colour colour = has_colour ? *voxels.colours[at] : Colour{};
    sum.uniform = first || (sum.uniform && sum.highest == log_odds && sum.first == colour);
    if (first) sum.first = colour;
    sum.highest = std::max(sum.highest, log_odds);
    if (has_colour) {
      sum.count = std::max(sum.count, colour.count);
      ++sum.coloured;
      for (std::size_t i = 0; i < 3; ++i) sum.mean[i] += colour.mean[i];
    }
    if (max_depth_ == kDepth) nodes_[kDepth].paints.emplace_back(CellState{log_odds, colour});
  }
  sum.uniform = sum.uniform && octants == 0xff;
  add(kDepth - 1, octants, sum);
  return sum;
}

}  // namespace

Nodes occupied_nodes(const TileTree& tree, int max_depth) {
  if (tree.bricks() == nullptr) return {};
  Collector collector(*tree.bricks(), max_depth);
  collector.visit({0, 0});
  return collector.take();
}

}  // namespace voxatlas
