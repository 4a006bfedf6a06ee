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

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Where a ray is, slab by slab along its main axis; u and v are the other two, u the earlier one.
template <int kMain, class Blocks>
class SlabWalk {
 public:
  SlabWalk(const std::array<CarvedAxis, 3>& axes, const Blocks& blocks)
      : blocks_(blocks),
        u_time_(axes[kU].times.data()),
        v_time_(axes[kV].times.data()),
        a_(axes[kMain].first_cell),
        u_(axes[kU].first_cell),
        v_(axes[kV].first_cell),
        a_direction_(axes[kMain].direction),
        u_direction_(axes[kU].direction),
        v_direction_(axes[kV].direction) {}

  /// Marks a slab's cells, all of them, and goes on to the next; `end` is the t of its far border.
  void mark_slab(double end) {
    const int u_steps = before<kU, kMain>(*u_time_, end),
              v_steps = before<kV, kMain>(*v_time_, end);
    const int twice =
        before<kU, kMain>(u_time_[u_steps], end) | before<kV, kMain>(v_time_[v_steps], end);
    if (twice != 0) {
      mark_until(end);
      mark(u_, v_);
    } else {
      // Masks, not branches: what a ray does next is not to be guessed.
      const int u_first = before<kU, kV>(*u_time_, *v_time_);
      const int u_move = u_direction_ & -u_steps, v_move = v_direction_ & -v_steps;
      mark({u_, u_ + (u_move & -u_first), u_ + u_move},
           {v_, v_ + (v_move & (u_first - 1)), v_ + v_move});
      u_ += u_move, v_ += v_move;
      u_time_ += u_steps, v_time_ += v_steps;
    }
    a_ += a_direction_;
  }

  /// Marks one cell after the other up to a crossing of the main axis, but not the last one.
  void mark_until(double end) {
    for (;;) {
      const bool u_first = before<kU, kV>(*u_time_, *v_time_);
      const double next = u_first ? *u_time_ : *v_time_;
      const bool comes = u_first ? before<kU, kMain>(next, end) : before<kV, kMain>(next, end);
      if (!comes || next == kNever) return;
      mark(u_, v_);
      (u_first ? u_ : v_) += u_first ? u_direction_ : v_direction_;
      ++(u_first ? u_time_ : v_time_);
    }
  }

 private:
  static constexpr int kU = kMain == 0 ? 1 : 0, kV = kMain == 2 ? 1 : 2;

  void mark(int u, int v) {
    if (((a_ ^ block_a_) | (u ^ block_u_) | (v ^ block_v_)) >> blocks_.shift != 0) {
      block_a_ = a_, block_u_ = u, block_v_ = v;
      VoxelIndex cell;
      cell[kMain] = a_, cell[kU] = u, cell[kV] = v;
      words_ = blocks_.words(cell);
    }
    blocks_.set(words_, a_, u, v);
  }
  void mark(const std::array<int, 3>& u, const std::array<int, 3>& v) {
    const int apart = (a_ ^ block_a_) | (u[0] ^ block_u_) | (v[0] ^ block_v_) | (u[2] ^ block_u_) |
                      (v[2] ^ block_v_);
    if (apart >> blocks_.shift == 0) {
      blocks_.set(words_, a_, u, v);
    } else {
      for (std::size_t i = 0; i < 3; ++i) mark(u[i], v[i]);
    }
  }

  const Blocks blocks_;
  const double* u_time_;  ///< The next border of u; the same for v.
  const double* v_time_;
  int a_, u_, v_;
  const int a_direction_, u_direction_, v_direction_;
  int block_a_ = -1, block_u_ = 0, block_v_ = 0;  ///< Any cell of the current block; -1: none yet.
  std::uint64_t* words_ = nullptr;
};

template <template <int> class Blocks, int kMain>
void carve_slabs(const std::array<CarvedAxis, 3>& axes, Marks& misses) {
  SlabWalk<kMain, Blocks<kMain>> walk(axes, Blocks<kMain>(misses));
  const double* times = axes[kMain].times.data();
  for (std::uint32_t i = 0; i < axes[kMain].crossings; ++i) walk.mark_slab(times[i]);
  walk.mark_until(kNever);
}

template <template <int> class Blocks>
void carve_into(const std::array<CarvedAxis, 3>& axes, Marks& misses) {
  const auto x = axes[0].crossings, y = axes[1].crossings, z = axes[2].crossings;
  if (x + y + z == 0) return;
  if (x >= y && x >= z) {
    carve_slabs<Blocks, 0>(axes, misses);
  } else if (y >= z) {
    carve_slabs<Blocks, 1>(axes, misses);
  } else {
    carve_slabs<Blocks, 2>(axes, misses);
  }
}

}  // namespace

void CarvedAxis::aim(double origin, double end, int shift) {
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
  out[crossings] = out[crossings + 1] = kNever;
}

void Carver::carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                   Marks& misses) {
  if (misses.depth() == kDepth && voxels_.carve(origin_voxels, end_voxels, misses)) return;
  for (int axis = 0; axis < 3; ++axis) {
    axes_[static_cast<std::size_t>(axis)].aim(origin_voxels[axis], end_voxels[axis],
                                              kDepth - misses.depth());
  }
  if (misses.has_bricks()) {
    carve_into<BrickBlocks>(axes_, misses);
  } else {
    carve_into<TileBlocks>(axes_, misses);
  }
}

}  // namespace voxatlas
