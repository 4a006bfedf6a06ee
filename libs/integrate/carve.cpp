#include "integrate/carve.hpp"

#include <cstdlib>
#include <limits>

namespace voxatlas {
namespace {

constexpr std::array<std::uint16_t, 16> kSpread = {0,   1,   8,   9,   64,  65,  72,  73,
                                                   512, 513, 520, 521, 576, 577, 584, 585};

/// Where marks of depth 5..7 are: a block is a brick's plane of the main axis.
template <int kMain>
struct BrickBlocks {
  Marks& marks;
  int shift;  ///< From a cell to its brick.
  int up;     ///< From a cell to its lowest voxel.

  explicit BrickBlocks(Marks& m)
      : marks(m), shift(m.depth() - kBrickDepth), up(kDepth - m.depth()) {}

  std::uint64_t* words(const VoxelIndex& cell) const {
    const auto top = [&](int axis) {
      return std::uint32_t{kSpread[static_cast<std::size_t>(cell[axis] >> shift & 15)]} << axis;
    };
    const auto tile = marks.tile_slot(cell);
    return marks.planes(marks.brick_slot(tile, top(0) | top(1) | top(2)))[kMain].data();
  }
  std::uint64_t bit(int u, int v) const {
    return std::uint64_t{1} << ((v << up & 7) << 3 | (u << up & 7));
  }
  void set(std::uint64_t* words, int a, int u, int v) const { words[a << up & 7] |= bit(u, v); }
  void set(std::uint64_t* words, int a, const std::array<int, 3>& u,
           const std::array<int, 3>& v) const {
    words[a << up & 7] |= bit(u[0], v[0]) | bit(u[1], v[1]) | bit(u[2], v[2]);
  }
};

/// Where marks of depth 0..4 are: a block is a tile.
template <int kMain>
struct TileBlocks {
  static constexpr int kU = kMain == 0 ? 1 : 0, kV = kMain == 2 ? 1 : 2;
  Marks& marks;
  int shift;
  int wrap;

  explicit TileBlocks(Marks& m) : marks(m), shift(m.depth()), wrap((1 << m.depth()) - 1) {}

  std::uint64_t* words(const VoxelIndex& cell) const {
    return marks.tile(marks.tile_slot(cell)).top.data();
  }
  std::uint32_t part(int axis, int c) const {
    return std::uint32_t{kSpread[static_cast<std::size_t>(c & wrap)]} << axis;
  }
  void set(std::uint64_t* words, int a, int u, int v) const {
    const auto bit = part(kMain, a) | part(kU, u) | part(kV, v);
    words[bit >> 6] |= std::uint64_t{1} << (bit & 63);
  }
  void set(std::uint64_t* words, int a, const std::array<int, 3>& u,
           const std::array<int, 3>& v) const {
    for (std::size_t i = 0; i < 3; ++i) set(words, a, u[i], v[i]);
  }
};

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
void Carver::carve_slabs(const Blocks& blocks) {
  constexpr int kU = kMain == 0 ? 1 : 0, kV = kMain == 2 ? 1 : 2;
  const double* slab_times = axes_[kMain].times.data();
  const double* u_time = axes_[kU].times.data();
  const double* v_time = axes_[kV].times.data();
  const int u_direction = axes_[kU].direction, v_direction = axes_[kV].direction;
  int a = axes_[kMain].first_cell, u = axes_[kU].first_cell, v = axes_[kV].first_cell;
  int block_a = -1, block_u = 0, block_v = 0;  // Any cell of the current block.
  std::uint64_t* words = nullptr;

  const auto mark = [&](int at_u, int at_v) {
    if (((a ^ block_a) | (at_u ^ block_u) | (at_v ^ block_v)) >> blocks.shift != 0) {
      block_a = a, block_u = at_u, block_v = at_v;
      VoxelIndex cell;
      cell[kMain] = a, cell[kU] = at_u, cell[kV] = at_v;
      words = blocks.words(cell);
    }
    blocks.set(words, a, at_u, at_v);
  };
  // One cell after the other up to a crossing of the main axis; the last one is not marked.
  const auto mark_until = [&](double end) {
    for (;;) {
      const bool u_first = before<kU, kV>(*u_time, *v_time);
      const bool any = u_first ? before<kU, kMain>(*u_time, end) : before<kV, kMain>(*v_time, end);
      if (!any || (u_first ? *u_time : *v_time) == std::numeric_limits<double>::infinity()) return;
      mark(u, v);
      (u_first ? u : v) += u_first ? u_direction : v_direction;
      ++(u_first ? u_time : v_time);
    }
  };

  for (std::uint32_t slab = 0; slab < axes_[kMain].crossings; ++slab) {
    const double end = slab_times[slab];
    const int u_steps = before<kU, kMain>(*u_time, end), v_steps = before<kV, kMain>(*v_time, end);
    const int twice =
        before<kU, kMain>(u_time[u_steps], end) | before<kV, kMain>(v_time[v_steps], end);
    const int u_first = before<kU, kV>(*u_time, *v_time);
    const int u_move = u_direction & -u_steps, v_move = v_direction & -v_steps;
    const int u_mid = u + (u_move & -u_first), v_mid = v + (v_move & (u_first - 1));
    const int u_next = u + u_move, v_next = v + v_move;
    const int apart =
        (a ^ block_a) | (u ^ block_u) | (v ^ block_v) | (u_next ^ block_u) | (v_next ^ block_v);
    if (((apart >> blocks.shift) | twice) == 0) {
      blocks.set(words, a, {u, u_mid, u_next}, {v, v_mid, v_next});
    } else if (twice == 0) {
      mark(u, v);
      mark(u_mid, v_mid);
      mark(u_next, v_next);
    } else {
      mark_until(end);
      mark(u, v);
      a += axes_[kMain].direction;
      continue;
    }
    u = u_next, v = v_next;
    u_time += u_steps, v_time += v_steps;
    a += axes_[kMain].direction;
  }
  mark_until(std::numeric_limits<double>::infinity());
}

template <template <int> class Blocks>
void Carver::carve_into(Marks& misses) {
  const auto x = axes_[0].crossings, y = axes_[1].crossings, z = axes_[2].crossings;
  if (x + y + z == 0) return;
  if (x >= y && x >= z) {
    carve_slabs<0>(Blocks<0>(misses));
  } else if (y >= z) {
    carve_slabs<1>(Blocks<1>(misses));
  } else {
    carve_slabs<2>(Blocks<2>(misses));
  }
}

void Carver::carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                   Marks& misses) {
  if (misses.depth() == kDepth && voxels_.carve(origin_voxels, end_voxels, misses)) return;
  for (int axis = 0; axis < 3; ++axis) {
    axes_[static_cast<std::size_t>(axis)].aim(origin_voxels[axis], end_voxels[axis],
                                              kDepth - misses.depth());
  }
  if (misses.has_bricks()) {
    carve_into<BrickBlocks>(misses);
  } else {
    carve_into<TileBlocks>(misses);
  }
}

}  // namespace voxatlas
