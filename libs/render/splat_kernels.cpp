#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/splat_kernels.cpp"
#include <hwy/foreach_target.h>
// Highway includes this file once for each set of instructions; so first itself, then the others.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "render/splat_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Eight floats: the children of a node, the pixels of a block's row. They are one register, or two
/// or eight where registers are shorter.
using Floats = hn::CappedTag<float, 8>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using Float = hn::Vec<Floats>;
constexpr Floats kFloats;
constexpr Ints kInts;
constexpr Words kWords;

Float all(float x) { return hn::Set(kFloats, x); }

/// A set of lanes as bits, lane 0 lowest.
std::uint32_t bits_of(hn::Mask<Floats> mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(kFloats, mask, bytes.data());
  return bytes[0];
}

hn::Mask<Floats> mask_of(std::uint32_t bits) {
  const std::array<std::uint8_t, 8> bytes{static_cast<std::uint8_t>(bits)};
  return hn::LoadMaskBits(kFloats, bytes.data());
}

using Corner = std::array<std::int32_t, 3>;

/// Where the children of a node fall: pixels of the strip.
struct ChildRects {
  alignas(64) std::array<std::int32_t, 8> xa, ya, xb, yb;
  std::uint32_t visible = 0;  ///< Octants with any pixel and in range.
};

/// From one end of a child's silhouette to the other, and whether pixel middles lie between.
struct Span {
  Float first, last;
};

/// `kMap`: the camera is orthographic.
template <bool kMap>
class StripPainter {
 public:
  StripPainter(const SplatFrame& frame, SplatStrip& strip);

  void paint(const SplatTile& tile);

 private:
  hn::Mask<Floats> beside(const SplatFrame::Level& level, Float x, Float y, Float w) const;
  void visit(int depth, TreeChildren children, const Corner& corner);
  ChildRects project(int depth, const Corner& corner) const;
  Span span(std::size_t row, const SplatFrame::Level& level, Float middle, Float per_w) const;
  void draw_cube(const Corner& corner, int edge, const PixelRect& rect, std::uint32_t number);
  std::uint64_t draw_rows(std::size_t block, std::uint64_t pixels, std::uint32_t number);
  std::uint64_t draw_pixels(std::size_t block, std::uint64_t pixels, std::uint32_t number);

  const SplatFrame& frame_;
  SplatStrip& strip_;
  const SplatTile* tile_ = nullptr;
  std::array<float, 3> per_w_{};  // What a place is divided by: its z, or, of a map, nothing.
  std::uint32_t backwards_ = 0;   // Of a map: the axes down which its rays go.
  std::array<float, 4> sides_{};  // Left, right, upper, lower: pixels of the picture,
  std::array<float, 4> reach_{};  // and how far a cube with half an edge of 1 reaches across.
  std::array<float, 3> low_{}, high_{};  // The faces of the cube being drawn.
};

template <bool kMap>
StripPainter<kMap>::StripPainter(const SplatFrame& frame, SplatStrip& strip)
    : frame_(frame), strip_(strip) {
  sides_ = {static_cast<float>(strip.x0), static_cast<float>(strip.x0 + strip.width), 0,
            static_cast<float>(frame.height)};
  if (!kMap) per_w_ = frame.project[2];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (kMap) backwards_ |= (frame.ray[axis] < 0 ? 1u : 0u) << axis;
    for (std::size_t side = 0; side < 4; ++side) {
      reach_[side] += std::abs(frame.project[side / 2][axis] - sides_[side] * per_w_[axis]);
    }
  }
}

template <bool kMap>
void StripPainter<kMap>::paint(const SplatTile& tile) {
  tile_ = &tile;
  visit(0, {1, 0}, tile.corner);  // As the only child of a node twice as large.
}

/// A corner at offset o from a middle m falls |o.x - u o.z| / (m.z + o.z) from u = m.x / m.z at
/// most: with all |o| half an edge, this is the sum over the axes. Of a map, o.x from u = m.x.
template <bool kMap>
Span StripPainter<kMap>::span(std::size_t row, const SplatFrame::Level& level, Float middle,
                              Float per_w) const {
  const auto& p = frame_.project[row];
  const auto& w = per_w_;
  Float reach = hn::Abs(hn::Sub(all(p[0]), hn::Mul(middle, all(w[0]))));
  reach = hn::Add(reach, hn::Abs(hn::Sub(all(p[1]), hn::Mul(middle, all(w[1])))));
  reach = hn::Add(reach, hn::Abs(hn::Sub(all(p[2]), hn::Mul(middle, all(w[2])))));
  const Float pixels =
      hn::Add(hn::Mul(hn::Mul(reach, all(level.half * 1.01f)), per_w), all(frame_.slack_pixels));
  const Float at = hn::Sub(middle, all(0.5f));
  return {hn::Ceil(hn::Sub(at, pixels)), hn::Floor(hn::Add(at, pixels))};
}

/// Cubes that lie beside the strip as a whole: behind one of the four planes through its sides and
/// the eye. It holds for cubes around the eye's own plane, too, which fall on no pixels one could
/// name.
template <bool kMap>
hn::Mask<Floats> StripPainter<kMap>::beside(const SplatFrame::Level& level, Float x, Float y,
                                            Float w) const {
  // What rounding may do, as in SplatFrame, times the z that a point of the cube may have.
  const float reach_w = kMap ? 0 : level.reach_z;
  const Float slack = hn::Mul(all(frame_.slack_pixels), hn::Add(w, all(3 * reach_w)));
  const auto behind = [&](std::size_t side, Float inwards) {
    return hn::Lt(hn::Add(hn::Add(inwards, all(level.half * reach_[side])), slack), all(0));
  };
  const auto across = hn::Or(behind(0, hn::Sub(x, hn::Mul(all(sides_[0]), w))),
                             behind(1, hn::Sub(hn::Mul(all(sides_[1]), w), x)));
  const auto down = hn::Or(behind(2, y), behind(3, hn::Sub(hn::Mul(all(sides_[3]), w), y)));
  return hn::Or(across, down);
}

template <bool kMap>
ChildRects StripPainter<kMap>::project(int depth, const Corner& corner) const {
  const auto& level = frame_.levels[static_cast<std::size_t>(depth)];
  std::array<float, 3> base;
  for (std::size_t row = 0; row < 3; ++row) {
    const auto& p = frame_.project[row];
    base[row] = p[0] * static_cast<float>(corner[0]) + p[1] * static_cast<float>(corner[1]) +
                p[2] * static_cast<float>(corner[2]);
  }
  const Float left = all(0), right = all(static_cast<float>(strip_.width - 1));
  const Float bottom = all(static_cast<float>(frame_.height - 1));
  const Float x0 = all(static_cast<float>(strip_.x0));
  ChildRects rects;
  for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
    const Float z = hn::Add(all(base[2]), hn::Load(kFloats, level.z.data() + i));
    const Float nearest = hn::Sub(z, all(level.reach_z));
    const Float farthest = hn::Add(z, all(level.reach_z));
    const auto in_range = hn::And(hn::Ge(farthest, all(frame_.near_z - frame_.slack_z)),
                                  hn::Le(nearest, all(frame_.far_z + frame_.slack_z)));
    const Float w = kMap ? all(1) : z, nearest_w = kMap ? all(1) : nearest;
    const auto ahead = hn::Gt(nearest_w, hn::Max(all(0.25f), hn::Mul(w, all(frame_.steepest))));
    const Float per_w = hn::Div(all(1), w), per_nearest = hn::Div(all(1), nearest_w);
    const Float x = hn::Add(all(base[0]), hn::Load(kFloats, level.x.data() + i));
    const Float y = hn::Add(all(base[1]), hn::Load(kFloats, level.y.data() + i));
    const Span across = span(0, level, hn::Mul(x, per_w), per_nearest);
    const Span down = span(1, level, hn::Mul(y, per_w), per_nearest);
    // What is not ahead as a whole may be anywhere.
    const Float xa = hn::IfThenElse(ahead, hn::Max(hn::Sub(across.first, x0), left), left);
    const Float xb = hn::IfThenElse(ahead, hn::Min(hn::Sub(across.last, x0), right), right);
    const Float ya = hn::IfThenElse(ahead, hn::Max(down.first, left), left);
    const Float yb = hn::IfThenElse(ahead, hn::Min(down.last, bottom), bottom);
    const auto seen = hn::And(in_range, hn::And(hn::Le(xa, xb), hn::Le(ya, yb)));
    rects.visible |= bits_of(hn::AndNot(beside(level, x, y, w), seen)) << i;
    // Unseen lanes may hold anything: hold them within what an int takes.
    hn::Store(hn::ConvertTo(kInts, hn::Min(xa, right)), kInts, rects.xa.data() + i);
    hn::Store(hn::ConvertTo(kInts, hn::Max(xb, left)), kInts, rects.xb.data() + i);
    hn::Store(hn::ConvertTo(kInts, hn::Min(ya, bottom)), kInts, rects.ya.data() + i);
    hn::Store(hn::ConvertTo(kInts, hn::Max(yb, left)), kInts, rects.yb.data() + i);
  }
  return rects;
}

/// The children of one node, which have this depth, nearest first: whatever ray leaves the eye, it
/// enters octants in the order of how many of the three middle planes it has crossed.
template <bool kMap>
void StripPainter<kMap>::visit(int depth, TreeChildren children, const Corner& corner) {
  const ChildRects rects = project(depth, corner);
  const std::uint32_t seen = children.octants & rects.visible;
  if (seen == 0) return;
  const int edge = 1 << (kDepth - depth);
  std::uint32_t nearest = backwards_;  // The octant on the eye's side of each middle plane.
  for (std::size_t axis = 0; axis < 3 && !kMap; ++axis) {
    nearest |= (corner[axis] + edge <= 0 ? 1u : 0u) << axis;
  }
  for (std::uint32_t step = 0; step < 8; ++step) {
    const std::uint32_t octant = step ^ nearest;
    if ((seen & 1u << octant) == 0) continue;
    const PixelRect rect{rects.xa[octant], rects.ya[octant], rects.xb[octant], rects.yb[octant]};
    if (strip_.cull && strip_.coverage.covers(rect)) continue;
    const std::uint32_t node =
        children.first +
        static_cast<std::uint32_t>(std::popcount(children.octants & ((1u << octant) - 1)));
    const Corner child{corner[0] + (octant & 1 ? edge : 0), corner[1] + (octant & 2 ? edge : 0),
                       corner[2] + (octant & 4 ? edge : 0)};
    if (depth < tile_->depth) {
      if (const auto below = children_of(tile_->links, node); below.octants != 0) {
        visit(depth + 1, below, child);
        continue;
      }
    }
    draw_cube(child, edge, rect, tile_->first_number + node);
  }
}

/// Exactly the pixels whose ray meets the cube. Neighbours share their faces to the bit, so no ray
/// slips between them.
template <bool kMap>
void StripPainter<kMap>::draw_cube(const Corner& corner, int edge, const PixelRect& where,
                                   std::uint32_t number) {
  constexpr int kLarge = 3 * Coverage::kBlock;
  const bool large = where.xb - where.xa > kLarge || where.yb - where.ya > kLarge;
  const PixelRect rect = large ? frame_.tightened(corner, edge, where, strip_.x0) : where;
  if (rect.xa > rect.xb || rect.ya > rect.yb) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low_[axis] = static_cast<float>(corner[axis]) - frame_.in_voxel[axis];
    high_[axis] = static_cast<float>(corner[axis] + edge) - frame_.in_voxel[axis];
  }
  Coverage& coverage = strip_.coverage;
  for (int by = rect.ya >> 3; by <= rect.yb >> 3; ++by) {
    for (int bx = rect.xa >> 3; bx <= rect.xb >> 3; ++bx) {
      const std::size_t block = coverage.block_index(bx, by);
      const std::uint64_t open = Coverage::within(rect, bx, by) & ~coverage.drawn(block);
      if (open == 0) continue;
      constexpr int kFew = 3;
      const std::uint64_t met = std::popcount(open) <= kFew ? draw_pixels(block, open, number)
                                                            : draw_rows(block, open, number);
      if (met != 0) coverage.draw(bx, by, met);
    }
  }
}

template <bool kMap>
std::uint64_t StripPainter<kMap>::draw_rows(std::size_t block, std::uint64_t pixels,
                                            std::uint32_t number) {
  std::uint64_t met = 0;
  const std::size_t lanes = hn::Lanes(kFloats);
  for (int row = std::countr_zero(pixels) / 8; row * 8 < 64 - std::countl_zero(pixels); ++row) {
    for (std::size_t i = 0; i < 8; i += lanes) {
      const std::size_t shift = static_cast<std::size_t>(row) * 8 + i;
      const auto open = static_cast<std::uint32_t>(pixels >> shift & 0xff) & ((1u << lanes) - 1);
      if (open == 0) continue;
      const std::size_t at = block * 64 + shift;
      Float in = all(frame_.near_z), out = all(frame_.far_z);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Float inverse = hn::LoadU(kFloats, strip_.inverse[axis].data() + at);
        Float low = all(low_[axis]), high = all(high_[axis]);
        if constexpr (kMap) {
          const Float start = hn::LoadU(kFloats, strip_.start[axis].data() + at);
          low = hn::Sub(low, start);
          high = hn::Sub(high, start);
        }
        const Float a = hn::Mul(low, inverse), b = hn::Mul(high, inverse);
        in = hn::Max(in, hn::Min(a, b));
        out = hn::Min(out, hn::Max(a, b));
      }
      const auto hit = hn::And(hn::Le(in, out), mask_of(open));
      const std::uint32_t hits = bits_of(hit);
      if (hits == 0) continue;
      met |= std::uint64_t{hits} << shift;
      hn::BlendedStore(hn::Mul(in, all(frame_.voxel_metres)), hit, kFloats, strip_.z.data() + at);
      hn::BlendedStore(hn::Set(kWords, number), hn::RebindMask(kWords, hit), kWords,
                       strip_.cell.data() + at);
    }
  }
  return met;
}

/// The same, one by one: cheaper where there are few.
template <bool kMap>
std::uint64_t StripPainter<kMap>::draw_pixels(std::size_t block, std::uint64_t pixels,
                                              std::uint32_t number) {
  std::uint64_t met = 0;
  for (; pixels != 0; pixels &= pixels - 1) {
    const std::size_t at = block * 64 + static_cast<std::size_t>(std::countr_zero(pixels));
    float in = frame_.near_z, out = frame_.far_z;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float inverse = strip_.inverse[axis][at];
      const float start = kMap ? strip_.start[axis][at] : 0;
      const float a = (low_[axis] - start) * inverse, b = (high_[axis] - start) * inverse;
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    if (!(in <= out)) continue;
    met |= pixels & -pixels;
    strip_.z[at] = in * frame_.voxel_metres;
    strip_.cell[at] = number;
  }
  return met;
}

template <bool kMap>
void paint_all(const SplatFrame& frame, std::span<const SplatTile> tiles, SplatStrip& strip) {
  StripPainter<kMap> painter(frame, strip);
  for (const SplatTile& tile : tiles) painter.paint(tile);
}

void splat_strip(const SplatFrame& frame, std::span<const SplatTile> tiles, SplatStrip& strip) {
  frame.map ? paint_all<true>(frame, tiles, strip) : paint_all<false>(frame, tiles, strip);
}

}  // namespace
}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace voxatlas {

HWY_EXPORT(splat_strip);

void splat(const SplatFrame& frame, std::span<const SplatTile> tiles, SplatStrip& strip) {
  HWY_DYNAMIC_DISPATCH(splat_strip)(frame, tiles, strip);
}

}  // namespace voxatlas
#endif
