#include "integrate/carve.hpp"

#include <cstdlib>
#include <limits>

namespace voxatlas {
namespace {

constexpr std::array<std::uint16_t, 16> kSpread = {0,   1,   8,   9,   64,  65,  72,  73,
                                                   512, 513, 520, 521, 576, 577, 584, 585};

/// Where marks of depth 5..7 are: a block is a brick.
struct BrickBlocks {
  Marks& marks;
  int shift;  ///< From a cell to its brick.
  int up;     ///< From a cell to its lowest voxel.

  explicit BrickBlocks(Marks& m)
      : marks(m), shift(m.depth() - kBrickDepth), up(kDepth - m.depth()) {}

  /// An axis' share of a cell's bit in its block.
  std::uint32_t part(int axis, int c) const {
    return (static_cast<std::uint32_t>(c) << up & 7) << 3 * axis;
  }
  std::uint64_t* words(const VoxelIndex& cell) const {
    const auto top = [&](int axis) {
      return std::uint32_t{kSpread[static_cast<std::size_t>(cell[axis] >> shift & 15)]} << axis;
    };
    const auto tile = marks.tile_slot(cell);
    return marks.bits(marks.brick_slot(tile, top(0) | top(1) | top(2))).data();
  }
};

/// Where marks of depth 0..4 are: a block is a tile.
struct TileBlocks {
  Marks& marks;
  int shift;
  int wrap;

  explicit TileBlocks(Marks& m) : marks(m), shift(m.depth()), wrap((1 << m.depth()) - 1) {}

  std::uint32_t part(int axis, int c) const {
    return std::uint32_t{kSpread[static_cast<std::size_t>(c & wrap)]} << axis;
  }
  std::uint64_t* words(const VoxelIndex& cell) const {
    return marks.tile(marks.tile_slot(cell)).top.data();
  }
};

inline void set_bit(std::uint64_t* words, std::uint32_t bit) {
  words[bit >> 6] |= std::uint64_t{1} << (bit & 63);
}

/// Whether a crossing of one axis comes before one of another: ties in the order x, y, z.
template <int kAxis, int kOther>
bool before(double t, double other) {
  return kAxis < kOther ? t <= other : t < other;
}

}  // namespace

void Carver::Axis::aim(double origin, double end, int shift) {
  // Not negative, so cutting the fraction off is the floor.
  first_cell = static_cast<int>(origin) >> shift;
  const int last_cell = static_cast<int>(end) >> shift;
  direction = last_cell < first_cell ? -1 : 1;
  crossings = static_cast<std::uint32_t>(std::abs(last_cell - first_cell));
  if (times.size() < crossings + 2) times.resize(2 * crossings + 64);
  // The border below a cell bears the cell's number, the one above it the next.
  const int first_border = last_cell < first_cell ? first_cell : first_cell + 1;
  const double inverse = 1 / (end - origin);
  double* out = times.data();
  for (int i = 0; i < static_cast<int>(crossings); ++i) {
    const int border = (first_border + direction * i) << shift;
    out[i] = (border - origin) * inverse;
  }
  out[crossings] = out[crossings + 1] = std::numeric_limits<double>::infinity();
}

template <int kMain, class Blocks>
void Carver::carve_slabs(Blocks& blocks) {
  constexpr int kU = kMain == 0 ? 1 : 0, kV = kMain == 2 ? 1 : 2;
  const double* slab_times = axes_[kMain].times.data();
  const double* u_time = axes_[kU].times.data();
  const double* v_time = axes_[kV].times.data();
  const int u_direction = axes_[kU].direction, v_direction = axes_[kV].direction;
  VoxelIndex cell(axes_[0].first_cell, axes_[1].first_cell, axes_[2].first_cell);
  VoxelIndex block_cell = cell;
  std::uint64_t* words = blocks.words(cell);

  const auto enter_block = [&] {
    const int outside =
        (cell[0] ^ block_cell[0]) | (cell[1] ^ block_cell[1]) | (cell[2] ^ block_cell[2]);
    if (outside >> blocks.shift != 0) words = blocks.words(block_cell = cell);
  };
  const auto mark = [&] {
    enter_block();
    set_bit(words, blocks.part(0, cell[0]) | blocks.part(1, cell[1]) | blocks.part(2, cell[2]));
  };
  // One cell after the other up to a crossing of the main axis; the last one is not marked.
  const auto mark_until = [&](double end) {
    for (;;) {
      const bool u_first = before<kU, kV>(*u_time, *v_time);
      const bool any = u_first ? before<kU, kMain>(*u_time, end) : before<kV, kMain>(*v_time, end);
      if (!any || (u_first ? *u_time : *v_time) == std::numeric_limits<double>::infinity()) return;
      mark();
      cell[u_first ? kU : kV] += u_first ? u_direction : v_direction;
      ++(u_first ? u_time : v_time);
    }
  };

  for (std::uint32_t slab = 0; slab < axes_[kMain].crossings; ++slab) {
    const double end = slab_times[slab];
    const int a = cell[kMain], u = cell[kU], v = cell[kV];
    const int u_steps = before<kU, kMain>(*u_time, end), v_steps = before<kV, kMain>(*v_time, end);
    const int u_next = u + (u_steps ? u_direction : 0), v_next = v + (v_steps ? v_direction : 0);
    enter_block();
    const int outside = (u_next ^ u) | (v_next ^ v);
    const bool twice =
        before<kU, kMain>(u_time[u_steps], end) || before<kV, kMain>(v_time[v_steps], end);
    if (outside >> blocks.shift != 0 || twice) {
      mark_until(end);
      mark();
    } else {
      const bool u_first = before<kU, kV>(*u_time, *v_time);
      const auto part = blocks.part(kMain, a);
      const auto u_part = blocks.part(kU, u), u_next_part = blocks.part(kU, u_next);
      const auto v_part = blocks.part(kV, v), v_next_part = blocks.part(kV, v_next);
      set_bit(words, part | u_part | v_part);
      set_bit(words, part | (u_first ? u_next_part | v_part : u_part | v_next_part));
      set_bit(words, part | u_next_part | v_next_part);
      u_time += u_steps;
      v_time += v_steps;
      cell[kU] = u_next;
      cell[kV] = v_next;
    }
    cell[kMain] += axes_[kMain].direction;
  }
  mark_until(std::numeric_limits<double>::infinity());
}

template <class Blocks>
void Carver::carve_into(Blocks blocks) {
  const auto x = axes_[0].crossings, y = axes_[1].crossings, z = axes_[2].crossings;
  if (x + y + z == 0) return;
  if (x >= y && x >= z) {
    carve_slabs<0>(blocks);
  } else if (y >= z) {
    carve_slabs<1>(blocks);
  } else {
    carve_slabs<2>(blocks);
  }
}

void Carver::carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                   Marks& misses) {
  for (int axis = 0; axis < 3; ++axis) {
    axes_[static_cast<std::size_t>(axis)].aim(origin_voxels[axis], end_voxels[axis],
                                              kDepth - misses.depth());
  }
  if (misses.has_bricks()) {
    carve_into(BrickBlocks(misses));
  } else {
    carve_into(TileBlocks(misses));
  }
}

}  // namespace voxatlas
