#include "integrate/carve_voxels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "integrate/carve_voxels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOX_CARVE_VOXELS_ONCE
#define VOX_CARVE_VOXELS_ONCE

#include <algorithm>
#include <cstdlib>

namespace voxatlas {
namespace {

constexpr std::size_t kMargin = 8;  ///< Cells before and after a ray's that vectors may read.

struct RayAxis {
  double origin, delta, inverse;
  std::int32_t first, last;  ///< Voxels of the two ends.

  bool up() const { return last >= first; }
  std::int32_t low() const { return std::min(first, last); }
  std::int32_t high() const { return std::max(first, last); }
};

/// A ray seen from its main axis; u and v are the others, u the earlier one.
struct SlabRay {
  int main;
  RayAxis a, u, v;
  /// u and v where the ray crosses the main axis' borders, ascending: cells[i] is that at the
  /// border low + i, the first and the last being those of the ends.
  std::int32_t* u_cells;
  std::int32_t* v_cells;
};

std::uint64_t* plane_of(Marks& marks, const SlabRay& ray, std::int32_t a, std::int32_t u,
                        std::int32_t v) {
  VoxelIndex brick;
  brick[ray.main] = a;
  brick[ray.main == 0 ? 1 : 0] = u;
  brick[ray.main == 2 ? 1 : 2] = v;
  const auto tile = marks.tile_slot(brick * 8);
  const auto top = [&](int axis) { return static_cast<std::uint32_t>(brick[axis]) & 15; };
  const auto slot = marks.brick_slot(tile, top_bit(top(0), top(1), top(2)));
  return marks.planes(slot)[static_cast<std::size_t>(ray.main)].data();
}

}  // namespace
}  // namespace voxatlas
#endif

HWY_BEFORE_NAMESPACE();
namespace voxatlas {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET <= HWY_AVX2

using Doubles = hn::CappedTag<double, 8>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using Words = hn::Rebind<std::uint64_t, Doubles>;

/// Whether a crossing of another axis comes before one of the main axis.
template <bool kTiesFirst, class V>
auto before(V t, V main_t) {
  if constexpr (kTiesFirst) {
    return hn::Le(t, main_t);
  } else {
    return hn::Lt(t, main_t);
  }
}

/// The cell on `axis` at each of the main axis' borders first_border + i.
template <bool kTiesFirst>
HWY_ATTR void cells_at_borders(const RayAxis& main, std::int32_t first_border, std::size_t count,
                               const RayAxis& axis, std::int32_t* cells) {
  const Doubles d;
  const auto one = hn::Set(d, 1.0), zero = hn::Zero(d);
  const auto low = hn::Set(d, axis.low()), high = hn::Set(d, axis.high());
  const auto origin = hn::Set(d, axis.origin), inverse = hn::Set(d, axis.inverse);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto border = hn::Iota(d, first_border + static_cast<double>(i));
    const auto t = hn::Mul(hn::Sub(border, hn::Set(d, main.origin)), hn::Set(d, main.inverse));
    auto cell = hn::Floor(hn::Add(hn::Mul(t, hn::Set(d, axis.delta)), origin));
    const auto t_lower = hn::Mul(hn::Sub(cell, origin), inverse);
    const auto t_upper = hn::Mul(hn::Sub(hn::Add(cell, one), origin), inverse);
    const auto lower = hn::IfThenElse(before<kTiesFirst>(t_lower, t), one, zero);
    const auto upper = hn::IfThenElse(before<kTiesFirst>(t_upper, t), one, zero);
    // Going up, the lower border must have been crossed and the upper one not; down, vice versa.
    cell = hn::Add(cell, axis.up() ? hn::Sub(hn::Add(upper, lower), one)
                                   : hn::Sub(one, hn::Add(upper, lower)));
    cell = hn::Min(hn::Max(cell, low), high);
    hn::StoreU(hn::DemoteTo(Ints(), cell), Ints(), cells + i);
  }
}

using Longs = hn::Rebind<std::int64_t, Doubles>;
constexpr std::size_t kLanes = hn::MaxLanes(Doubles());
constexpr std::size_t kParts = 8 / kLanes;  ///< Vectors to a brick's eight slabs.

/// The three cells of each of eight slabs: their bits in a word of the plane, and their bricks as
/// one number.
struct SlabCells {
  hn::Vec<Words> bits[kParts][3];
  hn::Vec<Longs> bricks[kParts][3];
};

std::int64_t brick_number(std::int32_t brick_u, std::int32_t brick_v) {
  return static_cast<std::int64_t>(brick_u) << 32 | brick_v;
}

/// The bit of a cell and its brick; no bit where `none` is set.
HWY_ATTR void place(hn::Vec<Longs> u, hn::Vec<Longs> v, hn::Mask<Words> none, hn::Vec<Words>& bit,
                    hn::Vec<Longs>& brick) {
  const Longs d;
  const Words dw;
  const auto seven = hn::Set(d, 7);
  const auto at = hn::Or(hn::ShiftLeft<3>(hn::And(v, seven)), hn::And(u, seven));
  bit = hn::IfThenZeroElse(none, hn::Shl(hn::Set(dw, 1), hn::BitCast(dw, at)));
  brick = hn::Or(hn::ShiftLeft<32>(hn::ShiftRight<3>(u)), hn::ShiftRight<3>(v));
}

/// The t at which the axis' next border is crossed, going on from `cell`.
template <class V>
HWY_ATTR auto next_time(const RayAxis& axis, V cell) {
  const Doubles d;
  const auto border = hn::Add(hn::PromoteTo(d, cell), hn::Set(d, axis.up() ? 1.0 : 0.0));
  return hn::Mul(hn::Sub(border, hn::Set(d, axis.origin)), hn::Set(d, axis.inverse));
}

/// The cells of the slabs a, a + 1, ..., a vector of them.
HWY_ATTR void find_cells(const SlabRay& ray, std::int32_t a, hn::Vec<Words>* bits,
                         hn::Vec<Longs>* bricks) {
  const Ints di;
  const Longs d;
  const Words dw;
  const auto at = static_cast<std::ptrdiff_t>(a) - ray.a.low();
  auto u_in = hn::LoadU(di, ray.u_cells + at), u_out = hn::LoadU(di, ray.u_cells + at + 1);
  auto v_in = hn::LoadU(di, ray.v_cells + at), v_out = hn::LoadU(di, ray.v_cells + at + 1);
  if (!ray.a.up()) {
    std::swap(u_in, u_out);
    std::swap(v_in, v_out);
  }
  const auto u_first = hn::RebindMask(d, hn::Le(next_time(ray.u, u_in), next_time(ray.v, v_in)));
  const auto u0 = hn::PromoteTo(d, u_in), u2 = hn::PromoteTo(d, u_out);
  const auto v0 = hn::PromoteTo(d, v_in), v2 = hn::PromoteTo(d, v_out);
  const auto slab = hn::Iota(d, a);
  const auto outside = hn::RebindMask(
      dw, hn::Or(hn::Lt(slab, hn::Set(d, ray.a.low())), hn::Gt(slab, hn::Set(d, ray.a.high()))));
  place(u0, v0, outside, bits[0], bricks[0]);
  place(hn::IfThenElse(u_first, u2, u0), hn::IfThenElse(u_first, v0, v2), outside, bits[1],
        bricks[1]);
  place(u2, v2, outside, bits[2], bricks[2]);
  const auto ahead = static_cast<std::int64_t>(ray.a.last) - a;
  if (ahead < 0 || ahead >= static_cast<std::int64_t>(kLanes)) return;
  // The end's cell is in its slab once at least, in the place of the last one: it gets no mark.
  const auto end_slab = hn::Eq(slab, hn::Set(d, ray.a.last));
  const auto end_bit = bits[2];
  const auto end_brick = bricks[2];
  for (int i = 0; i < 3; ++i) {
    const auto same = hn::And(hn::RebindMask(dw, hn::And(end_slab, hn::Eq(bricks[i], end_brick))),
                              hn::Eq(bits[i], end_bit));
    bits[i] = hn::IfThenZeroElse(same, bits[i]);
  }
}

/// ORs into one brick what is in it; `all` where everything is.
HWY_ATTR void mark_brick(const SlabRay& ray, const SlabCells& cells, const VoxelIndex& brick,
                         bool all, Marks& marks) {
  const Longs d;
  const Words dw;
  const auto number = hn::Set(d, brick_number(brick[1], brick[2]));
  hn::Vec<Words> words[kParts];
  bool any = false;
  for (std::size_t part = 0; part < kParts; ++part) {
    const auto* bits = cells.bits[part];
    if (all) {
      words[part] = hn::Or(hn::Or(bits[0], bits[1]), bits[2]);
    } else {
      words[part] = hn::Zero(dw);
      for (int i = 0; i < 3; ++i) {
        const auto here = hn::RebindMask(dw, hn::Eq(cells.bricks[part][i], number));
        words[part] = hn::Or(words[part], hn::IfThenElseZero(here, bits[i]));
      }
    }
    any = any || !hn::AllTrue(dw, hn::Eq(words[part], hn::Zero(dw)));
  }
  if (!any) return;
  std::uint64_t* plane = plane_of(marks, ray, brick[0], brick[1], brick[2]);
  for (std::size_t part = 0; part < kParts; ++part) {
    auto* out = plane + part * kLanes;
    hn::StoreU(hn::Or(hn::LoadU(dw, out), words[part]), dw, out);
  }
}

/// Marks the eight slabs of a ray that lie between two borders of bricks.
HWY_ATTR void mark_slabs(const SlabRay& ray, std::int32_t brick_a, Marks& marks) {
  SlabCells cells;
  for (std::size_t part = 0; part < kParts; ++part) {
    find_cells(ray, brick_a * 8 + static_cast<std::int32_t>(part * kLanes), cells.bits[part],
               cells.bricks[part]);
  }
  const auto from = std::max(brick_a * 8, ray.a.low()) - ray.a.low();
  const auto to = std::min(brick_a * 8 + 7, ray.a.high()) - ray.a.low() + 1;
  const auto [u_low, u_high] = std::minmax({ray.u_cells[from] >> 3, ray.u_cells[to] >> 3});
  const auto [v_low, v_high] = std::minmax({ray.v_cells[from] >> 3, ray.v_cells[to] >> 3});
  const bool all = u_low == u_high && v_low == v_high;
  for (auto u = u_low; u <= u_high; ++u) {
    for (auto v = v_low; v <= v_high; ++v) mark_brick(ray, cells, {brick_a, u, v}, all, marks);
  }
}

/// False where rounding puts two borders of one axis into one slab.
bool one_step_a_slab(const std::int32_t* cells, std::size_t count) {
  int farthest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    farthest = std::max(farthest, std::abs(cells[i + 1] - cells[i]));
  }
  return farthest <= 1;
}

template <bool kUFirst, bool kVFirst>
HWY_ATTR bool carve_slabs(const SlabRay& ray, Marks& marks) {
  const auto borders = static_cast<std::size_t>(ray.a.high() - ray.a.low());
  const auto fill = [&](const RayAxis& axis, std::int32_t* cells) {
    cells[0] = ray.a.up() ? axis.first : axis.last;
    cells[borders + 1] = ray.a.up() ? axis.last : axis.first;
  };
  cells_at_borders<kUFirst>(ray.a, ray.a.low() + 1, borders, ray.u, ray.u_cells + 1);
  cells_at_borders<kVFirst>(ray.a, ray.a.low() + 1, borders, ray.v, ray.v_cells + 1);
  fill(ray.u, ray.u_cells);
  fill(ray.v, ray.v_cells);
  if (!one_step_a_slab(ray.u_cells, borders + 1) || !one_step_a_slab(ray.v_cells, borders + 1)) {
    return false;
  }
  for (auto brick = ray.a.low() >> 3; brick <= ray.a.high() >> 3; ++brick) {
    mark_slabs(ray, brick, marks);
  }
  return true;
}

HWY_ATTR bool carve_ray(const SlabRay& ray, Marks& marks) {
  if (ray.main == 0) return carve_slabs<false, false>(ray, marks);
  if (ray.main == 1) return carve_slabs<true, false>(ray, marks);
  return carve_slabs<true, true>(ray, marks);
}

#else

bool carve_ray(const SlabRay&, Marks&) { return false; }

#endif

}  // namespace HWY_NAMESPACE
}  // namespace voxatlas
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace voxatlas {

HWY_EXPORT(carve_ray);

bool VoxelCarver::carve(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                        Marks& misses) {
  RayAxis axes[3];
  for (int i = 0; i < 3; ++i) {
    const double delta = end_voxels[i] - origin_voxels[i];
    // Not negative, so cutting the fraction off is the floor.
    axes[i] = {origin_voxels[i], delta, 1 / delta, static_cast<std::int32_t>(origin_voxels[i]),
               static_cast<std::int32_t>(end_voxels[i])};
  }
  const auto length = [&](int i) { return std::abs(axes[i].delta); };
  int main = length(0) >= length(1) ? 0 : 1;
  if (length(2) > length(main)) main = 2;
  if (axes[main].delta == 0) return true;  // No way, no cells before the end's.
  const auto room = static_cast<std::size_t>(axes[main].high() - axes[main].low()) + 3 * kMargin;
  if (u_cells_.size() < room) {
    u_cells_.resize(2 * room);
    v_cells_.resize(2 * room);
  }
  const SlabRay ray{main,
                    axes[main],
                    axes[main == 0 ? 1 : 0],
                    axes[main == 2 ? 1 : 2],
                    u_cells_.data() + kMargin,
                    v_cells_.data() + kMargin};
  return HWY_DYNAMIC_DISPATCH(carve_ray)(ray, misses);
}

}  // namespace voxatlas
#endif
