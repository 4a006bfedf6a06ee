#include "integrate/carve_steps.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "integrate/carve_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOX_CARVE_STEPS_ONCE
#define VOX_CARVE_STEPS_ONCE

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace voxatlas {
namespace {

constexpr int kFraction = 44;      ///< Bits of fraction in 64: 20 000 slabs err by 2^-29.
constexpr int kLaneFraction = 27;  ///< The same in a lane.
constexpr int kBrick = kFraction + 3;
constexpr std::int32_t kLaneMask = (1 << kLaneFraction) - 1;
constexpr std::int32_t kClose = 1 << (kLaneFraction - 22);  ///< To a border.
constexpr float kTogether = 1 << (kLaneFraction - 20);      ///< Crossings of u and v.

/// One of the two axes across the slabs.
struct Side {
  std::size_t axis;
  std::int64_t at;           ///< At the lower border of the first brick, from base's; fixed point.
  std::int64_t slope;        ///< Voxels a slab, -1 to 1; fixed point.
  std::int32_t base;         ///< A brick.
  std::int32_t first, last;  ///< Voxels of the lower and of the upper end along the main axis.

  bool is_close() const {
    constexpr std::int64_t close = std::int64_t{kClose} << (kFraction - kLaneFraction);
    return ((at + close) & ((std::int64_t{1} << kFraction) - 1)) < 2 * close;
  }
};

/// A ray seen from its main axis, from its lower end to its upper one; u is the earlier axis.
struct SlabRay {
  std::size_t main;
  std::int32_t first, last;  ///< Slabs.
  bool up;  ///< The ray runs up the main axis: the upper end's cell is not its own.
  Side u, v;
};

SlabRay aim(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, int main) {
  const Eigen::Vector3d delta = end - origin;
  const bool up = delta[main] > 0;
  const Eigen::Vector3d &low = up ? origin : end, &high = up ? end : origin;
  // Not negative, so cutting the fraction off is the floor.
  const auto cell = [](double x) { return static_cast<std::int32_t>(x); };
  const double entry = (cell(low[main]) & ~7) - low[main];
  const auto side = [&](int axis) {
    constexpr double unit = std::int64_t{1} << kFraction;
    const double slope = delta[axis] / delta[main] * unit;
    const auto base = cell(low[axis]) & ~7;
    return Side{static_cast<std::size_t>(axis),
                static_cast<std::int64_t>((low[axis] - base) * unit) +
                    static_cast<std::int64_t>(entry * slope),
                static_cast<std::int64_t>(slope),
                base >> 3,
                cell(low[axis]),
                cell(high[axis])};
  };
  return {static_cast<std::size_t>(main), cell(low[main]),        cell(high[main]), up,
          side(main == 0 ? 1 : 0),        side(main == 2 ? 1 : 2)};
}

HWY_NOINLINE std::uint32_t add_brick(const SlabRay& ray, std::int32_t a, std::int32_t u,
                                     std::int32_t v, Marks& marks) {
  VoxelIndex brick;
  brick[static_cast<int>(ray.main)] = a;
  brick[static_cast<int>(ray.u.axis)] = u;
  brick[static_cast<int>(ray.v.axis)] = v;
  return marks.add_brick(brick);
}

}  // namespace
}  // namespace voxatlas
#endif

HWY_BEFORE_NAMESPACE();
namespace voxatlas {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET <= HWY_AVX2

using Ints = hn::CappedTag<std::int32_t, 8>;
using Lanes = hn::Rebind<std::uint32_t, Ints>;
using Floats = hn::Rebind<float, Ints>;
using Words = hn::Repartition<std::uint64_t, Lanes>;
using Row = hn::Vec<Lanes>;

/// Which slab of eight a lane has: so ordered that interleaving lower and upper halves of words
/// leaves the words in order.
alignas(32) constexpr std::uint32_t kSlabs[8] = {0, 1, 4, 5, 2, 3, 6, 7};

/// Left shifts by 32 and more must give 0. Highway promises nothing there; the instruction of all
/// targets compiled here, VPSLLVD, does.
HWY_ATTR Row shift(Row bits, Row by) { return hn::Shl(bits, by); }

/// A side's line over the steps of one ray.
struct Line {
  std::int64_t at, step;      ///< At the step's lower border; a brick further.
  std::int64_t lower, upper;  ///< From `at` to the lowest and highest of a step.
  Row in, out;                ///< From `at` to where each slab begins and ends.
  Row flip;                   ///< What makes a fraction the way to the next border.
  hn::Vec<Floats> steepness;  ///< Size of the slope.

  HWY_ATTR explicit Line(const Side& side)
      : at(side.at),
        step(side.slope * 8),
        lower(std::min<std::int64_t>(step, 0)),
        upper(std::max<std::int64_t>(step, 0)) {
    const Lanes d;
    constexpr int cut = kFraction - kLaneFraction;
    const auto slope = static_cast<std::uint32_t>((side.slope + (1 << (cut - 1))) >> cut);
    in = hn::Mul(hn::Load(d, kSlabs), hn::Set(d, slope));
    out = hn::Add(in, hn::Set(d, slope));
    flip = hn::Set(d, side.slope > 0 ? ~0u : 0u);
    steepness = hn::Set(Floats(), static_cast<float>(std::abs(side.slope)) /
                                      static_cast<float>(std::int64_t{1} << kFraction));
  }
};

/// A line within one step: bricks counted from the side's base, lanes from the lower brick.
struct Reach {
  std::int32_t low, high;  ///< Bricks; at most one apart.
  Row in, out;

  HWY_ATTR explicit Reach(const Line& line)
      : low(static_cast<std::int32_t>((line.at + line.lower) >> kBrick)),
        high(static_cast<std::int32_t>((line.at + line.upper) >> kBrick)) {
    const auto at = line.at - (std::int64_t{low} << kBrick);
    const auto start =
        hn::Set(Lanes(), static_cast<std::uint32_t>(at >> (kFraction - kLaneFraction)));
    in = hn::Add(start, line.in);
    out = hn::Add(start, line.out);
  }
};

HWY_ATTR hn::Vec<Ints> fraction(Row lanes) {
  return hn::BitCast(Ints(), hn::And(lanes, hn::Set(Lanes(), kLaneMask)));
}

/// The cells of eight slabs as bits: those of v0 and of v1, and how far to shift them.
struct Rows {
  Row bits0, bits1, shift0, shift1;
};

HWY_ATTR Rows rows_of(Row u0, Row u1, Row v0, Row v1, hn::Mask<Lanes> u_first) {
  const auto one = hn::Set(Lanes(), 1u);
  const auto b0 = shift(one, u0), b1 = shift(one, u1), both = hn::Or(b0, b1);
  return {hn::IfThenElse(u_first, both, b0), hn::IfThenElse(u_first, b1, both),
          hn::ShiftLeft<3>(v0), hn::ShiftLeft<3>(v1)};
}

/// ORs rows into a brick's plane; what lies beyond its rows is shifted out.
HWY_INLINE HWY_ATTR void mark(const SlabRay& ray, std::int32_t a, std::int32_t u, std::int32_t v,
                              Row bits0, Row bits1, Row shift0, Row shift1, Marks& marks) {
  const Lanes d;
  const Words words;
  const auto half = hn::Set(d, 32u);
  const auto lower = hn::Or(shift(bits0, shift0), shift(bits1, shift1));
  const auto upper =
      hn::Or(shift(bits0, hn::Sub(shift0, half)), shift(bits1, hn::Sub(shift1, half)));
  const auto all = hn::BitCast(Ints(), hn::Or(lower, upper));
  if (hn::AllTrue(Ints(), hn::Eq(all, hn::Zero(Ints())))) return;
  u += ray.u.base, v += ray.v.base;
  auto slot = marks.slot_at(marks.place_on_axis(ray.main, a) + marks.place_on_axis(ray.u.axis, u) +
                            marks.place_on_axis(ray.v.axis, v));
  if (HWY_UNLIKELY(slot == 0)) slot = add_brick(ray, a, u, v, marks);
  auto* plane = marks.planes(slot)[ray.main].data();
  const auto first = hn::BitCast(words, hn::InterleaveLower(d, lower, upper));
  const auto second = hn::BitCast(words, hn::InterleaveUpper(d, lower, upper));
  hn::Store(hn::Or(hn::Load(words, plane), first), words, plane);
  hn::Store(hn::Or(hn::Load(words, plane + 4), second), words, plane + 4);
}

HWY_INLINE HWY_ATTR void mark_bricks(const SlabRay& ray, std::int32_t a, const Reach& u,
                                     const Reach& v, const Rows& rows, Marks& marks) {
  if (u.low == u.high && v.low == v.high) {
    return mark(ray, a, u.low, v.low, rows.bits0, rows.bits1, rows.shift0, rows.shift1, marks);
  }
  const Lanes d;
  const auto byte = hn::Set(d, 0xffu), brick = hn::Set(d, 64u);
  const auto shift0 = hn::Sub(rows.shift0, brick), shift1 = hn::Sub(rows.shift1, brick);
  for (auto at = u.low;; ++at) {
    const auto bits0 = at == u.low ? hn::And(rows.bits0, byte) : hn::ShiftRight<8>(rows.bits0);
    const auto bits1 = at == u.low ? hn::And(rows.bits1, byte) : hn::ShiftRight<8>(rows.bits1);
    mark(ray, a, at, v.low, bits0, bits1, rows.shift0, rows.shift1, marks);
    if (v.low != v.high) mark(ray, a, at, v.high, bits0, bits1, shift0, shift1, marks);
    if (at == u.high) return;
  }
}

/// The first and the last step: what lies before the ray's ends is no cell of its, and the ends'
/// cells are known. Of the end's own cell the bit is taken away.
HWY_NOINLINE HWY_ATTR Rows end_rows(const SlabRay& ray, std::int32_t a, const Reach& u,
                                    const Reach& v, hn::Mask<Lanes> u_first) {
  const Lanes d;
  const auto slab = hn::BitCast(Ints(), hn::Load(d, kSlabs));
  const auto first = hn::Set(Ints(), ray.first - 8 * a), last = hn::Set(Ints(), ray.last - 8 * a);
  const auto at_first = hn::RebindMask(d, hn::Eq(slab, first));
  const auto at_last = hn::RebindMask(d, hn::Eq(slab, last));
  const auto cell = [&](const Side& side, const Reach& reach, std::int32_t voxel) {
    return hn::Set(d, static_cast<std::uint32_t>(voxel - 8 * (side.base + reach.low)));
  };
  const auto u0 = hn::IfThenElse(at_first, cell(ray.u, u, ray.u.first), u.in);
  const auto v0 = hn::IfThenElse(at_first, cell(ray.v, v, ray.v.first), v.in);
  const auto u1 = hn::IfThenElse(at_last, cell(ray.u, u, ray.u.last), u.out);
  const auto v1 = hn::IfThenElse(at_last, cell(ray.v, v, ray.v.last), v.out);
  auto rows = rows_of(u0, u1, v0, v1, u_first);
  const auto none = hn::RebindMask(d, hn::Or(hn::Lt(slab, first), hn::Gt(slab, last)));
  const auto at_end = ray.up ? at_last : at_first;
  const auto end = hn::IfThenElseZero(at_end, shift(hn::Set(d, 1u), ray.up ? u1 : u0));
  const auto end_if_one_row = hn::IfThenElseZero(hn::Eq(v0, v1), end);
  rows.bits0 = hn::IfThenZeroElse(none, hn::AndNot(ray.up ? end_if_one_row : end, rows.bits0));
  rows.bits1 = hn::IfThenZeroElse(none, hn::AndNot(ray.up ? end : end_if_one_row, rows.bits1));
  return rows;
}

HWY_ATTR bool carve_ray(const SlabRay& ray, Marks& marks) {
  const Lanes d;
  Line u_line(ray.u), v_line(ray.v);
  const auto close = hn::Set(d, static_cast<std::uint32_t>(kClose));
  for (auto a = ray.first >> 3;; ++a) {
    Reach u(u_line), v(v_line);
    const auto nearest = hn::Min(fraction(hn::Add(u.out, close)), fraction(hn::Add(v.out, close)));
    const auto way = [&](Row in, const Line& line) {
      return hn::ConvertTo(Floats(), fraction(hn::Xor(in, line.flip)));
    };
    const auto earlier = hn::Sub(hn::Mul(way(u.in, u_line), v_line.steepness),
                                 hn::Mul(way(v.in, v_line), u_line.steepness));
    const auto together = hn::Lt(hn::Abs(earlier), hn::Set(Floats(), kTogether));
    const auto unsure =
        hn::Or(hn::Lt(nearest, hn::Set(Ints(), 2 * kClose)), hn::RebindMask(Ints(), together));
    if (HWY_UNLIKELY(!hn::AllFalse(Ints(), unsure))) return false;
    const auto u_first = hn::RebindMask(d, hn::Lt(earlier, hn::Zero(Floats())));
    u.in = hn::ShiftRight<kLaneFraction>(u.in), u.out = hn::ShiftRight<kLaneFraction>(u.out);
    v.in = hn::ShiftRight<kLaneFraction>(v.in), v.out = hn::ShiftRight<kLaneFraction>(v.out);
    if (a == ray.first >> 3 || a == ray.last >> 3) {
      mark_bricks(ray, a, u, v, end_rows(ray, a, u, v, u_first), marks);
      if (a == ray.last >> 3) return true;
    } else {
      mark_bricks(ray, a, u, v, rows_of(u.in, u.out, v.in, v.out, u_first), marks);
    }
    u_line.at += u_line.step;
    v_line.at += v_line.step;
  }
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

bool carve_steps(const Eigen::Vector3d& origin_voxels, const Eigen::Vector3d& end_voxels,
                 Marks& misses) {
  const Eigen::Vector3d way = (end_voxels - origin_voxels).cwiseAbs();
  int main = way[0] >= way[1] ? 0 : 1;
  if (way[2] > way[main]) main = 2;
  if (way[main] == 0) return true;  // No way, no cells before the end's.
  const auto ray = aim(origin_voxels, end_voxels, main);
  if (ray.u.is_close() || ray.v.is_close()) return false;
  return HWY_DYNAMIC_DISPATCH(carve_ray)(ray, misses);
}

}  // namespace voxatlas
#endif
