#include "render/occupied_nodes.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

using Nodes = std::array<std::vector<OccupiedNode>, kDepth + 1>;

/// What is occupied within a cell, taken together.
struct Sum {
  LogOdds highest = -1;                 ///< -1: nothing is occupied.
  bool uniform = true;                  ///< All voxels are known and alike: like `first`.
  Colour first;                         ///< Of any voxel; says something where uniform.
  std::uint16_t count = 0;              ///< Of the colours, the largest,
  std::uint32_t coloured = 0;           ///< how many voxels have one,
  std::array<std::uint64_t, 3> mean{};  ///< and the sum of theirs.

  /// Of a uniform cell.
  static Sum of(const CellState& state, std::uint32_t voxels) {
    Sum sum{state.log_odds, true, state.colour, state.colour.count, 0, {}};
    if (!state.colour.exists()) return sum;
    sum.coloured = voxels;
    for (std::size_t i = 0; i < 3; ++i) sum.mean[i] = std::uint64_t{state.colour.mean[i]} * voxels;
    return sum;
  }
  bool occupied() const { return highest >= 0; }

  /// Adds a child; the first comes to a new Sum.
  void add(const Sum& child, bool is_first) {
    uniform = child.uniform &&
              (is_first || (uniform && highest == child.highest && first == child.first));
    if (is_first) first = child.first;
    highest = std::max(highest, child.highest);
    if (child.coloured == 0) return;
    count = std::max(count, child.count);
    coloured += child.coloured;
    for (std::size_t i = 0; i < 3; ++i) mean[i] += child.mean[i];
  }
  /// The same as adding the Sum of one voxel, which is most of the work.
  void add_voxel(const CellState& state, bool is_first) {
    uniform = is_first || (uniform && highest == state.log_odds && first == state.colour);
    if (is_first) first = state.colour;
    highest = std::max(highest, state.log_odds);
    if (!state.colour.exists()) return;
    count = std::max(count, state.colour.count);
    ++coloured;
    for (std::size_t i = 0; i < 3; ++i) mean[i] += state.colour.mean[i];
  }
  /// As Summary::state.
  CellState state() const {
    CellState result{highest, {}};
    if (coloured == 0) return result;
    for (std::size_t i = 0; i < 3; ++i) {
      result.colour.mean[i] =
          static_cast<std::uint16_t>((2 * mean[i] + coloured) / (2 * std::uint64_t{coloured}));
    }
    result.colour.count = count;
    return result;
  }
};

/// The voxels of a layer that are below 0, as a layer of a VoxelMask: sign bits, four at a time.
std::uint64_t negative_of(const LogOdds* layer) {
  constexpr std::uint64_t kSigns = 0x0001'0001'0001'0001, kGather = 0x0001'0002'0004'0008;
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < 64; i += 4) {
    std::uint64_t four = 0;
    std::memcpy(&four, layer + i, sizeof four);
    bits |= ((four >> 15 & kSigns) * kGather >> 48 & 0xf) << i;
  }
  return bits;
}

/// The lowest bit of each byte.
constexpr std::uint64_t kLowestBits = 0x0101'0101'0101'0101;

/// Of each byte that is not 0 the lowest bit.
std::uint64_t lowest_of_bytes(std::uint64_t word) {
  constexpr std::uint64_t kLow7 = 0x7f7f'7f7f'7f7f'7f7f;
  return (((word & kLow7) + kLow7) | word) >> 7 & kLowestBits;
}

/// The occupied voxels of a mixed brick in Morton order, in which every cell of it is a run.
struct MortonVoxels {
  std::array<std::uint64_t, 8> occupied{};
  std::array<LogOdds, kBrickVoxels> log_odds;  // Only of those that are occupied.
  std::array<const Colour*, kBrickVoxels>
      colours;  // Not colours: those would be set to none first.

  MortonVoxels(const Brick& brick, const BrickColours* own) {
    static constexpr Colour kNone;
    for (unsigned z = 0; z < 8; ++z) {
      std::uint64_t left = brick.known[z] & ~negative_of(brick.log_odds.data() + 64 * z);
      for (; left != 0; left &= left - 1) {
        const unsigned voxel = 64 * z + static_cast<unsigned>(std::countr_zero(left));
        const unsigned at = kMortonOfVoxel[voxel];
        occupied[at / 64] |= std::uint64_t{1} << at % 64;
        log_odds[at] = brick.log_odds[voxel];
        colours[at] = &kNone;
      }
    }
    if (own == nullptr) return;
    own->for_each(
        [&](unsigned voxel, const Colour& colour) { colours[kMortonOfVoxel[voxel]] = &colour; });
  }
};

/// Goes through a tile once, in Morton order. What lies below a cell that turns out to be a leaf is
/// taken back.
class Collector {
 public:
  Collector(const BrickTable& table, int max_depth)
      : table_(table), max_depth_(max_depth), bricks_(table.maybe_occupied()) {}

  Sum visit(CellKey cell);
  Nodes take() { return std::move(nodes_); }

 private:
  Sum brick(std::uint32_t code);
  Sum cell_of_64(const MortonVoxels& voxels, std::uint32_t word, std::uint32_t brick);
  Sum cell_of_8(const MortonVoxels& voxels, std::uint32_t byte, std::uint32_t brick);
  void add(int depth, std::uint32_t code, const Sum& sum) {
    if (depth <= max_depth_) nodes_[static_cast<std::size_t>(depth)].push_back({code, sum.state()});
  }
  /// The eight nodes that were last added to a depth.
  void take_back(int depth) {
    if (depth > max_depth_) return;
    auto& nodes = nodes_[static_cast<std::size_t>(depth)];
    nodes.resize(nodes.size() - 8);
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
Sum Collector::visit(CellKey cell) {
  if (cell.depth == kBrickDepth) return brick(cell.code);
  Sum sum;
  unsigned occupied = 0;  // How many children.
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if (!any(cell.child(octant))) continue;
    const Sum child = visit(cell.child(octant));
    if (child.occupied()) sum.add(child, occupied++ == 0);
  }
  if (!sum.occupied()) return sum;
  sum.uniform = sum.uniform && occupied == 8;
  if (sum.uniform) take_back(cell.depth + 1);
  add(cell.depth, cell.code, sum);
  return sum;
}

Sum Collector::brick(std::uint32_t code) {
  Sum sum;
  if (table_.is_uniform(code)) {
    sum = Sum::of(table_.uniform_state(code), kBrickVoxels);
  } else {
    const MortonVoxels voxels(table_.mixed(code), table_.colours(code));
    for (std::uint32_t word = 0; word < 8; ++word) {
      if (voxels.occupied[word] == 0) continue;
      sum.add(cell_of_64(voxels, word, code), !sum.occupied());
    }
    if (!sum.occupied()) return sum;
    sum.uniform = false;  // It would be no mixed brick.
  }
  add(kBrickDepth, code, sum);
  return sum;
}

/// One that has something occupied, as the next.
Sum Collector::cell_of_64(const MortonVoxels& voxels, std::uint32_t word, std::uint32_t brick) {
  Sum sum;
  const std::uint64_t bytes = lowest_of_bytes(voxels.occupied[word]);
  for (std::uint64_t left = bytes; left != 0; left &= left - 1) {
    const std::uint32_t i = static_cast<std::uint32_t>(std::countr_zero(left)) / 8;
    sum.add(cell_of_8(voxels, word * 8 + i, brick), !sum.occupied());
  }
  sum.uniform = sum.uniform && bytes == kLowestBits;
  if (sum.uniform) take_back(kBrickDepth + 2);
  add(kBrickDepth + 1, brick << 3 | word, sum);
  return sum;
}

Sum Collector::cell_of_8(const MortonVoxels& voxels, std::uint32_t byte, std::uint32_t brick) {
  Sum sum;
  const std::uint64_t bits = voxels.occupied[byte / 8] >> byte % 8 * 8 & 0xff;
  bool first = true;
  for (std::uint64_t left = bits; left != 0; left &= left - 1) {
    const std::uint32_t at = byte * 8 + static_cast<std::uint32_t>(std::countr_zero(left));
    const CellState state{voxels.log_odds[at], *voxels.colours[at]};
    sum.add_voxel(state, std::exchange(first, false));
    if (max_depth_ == kDepth) nodes_[kDepth].push_back({brick << 9 | at, state});
  }
  sum.uniform = sum.uniform && bits == 0xff;
  if (sum.uniform) take_back(kDepth);
  add(kDepth - 1, brick << 6 | byte, sum);
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
