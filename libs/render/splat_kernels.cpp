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
#include "render/splat_pixels-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

/// Where the children of a node fall: pixels of the strip.
struct ChildRects {
  alignas(64) std::array<std::int32_t, 8> xa, ya, xb, yb;
  std::uint32_t visible = 0;  ///< Octants with any pixel and in range.
};

/// From one end of a child's silhouette to the other, and whether pixel middles lie between.
struct Span {
  Float first, last;
};

/// A node that falls on at most so many pixels is drawn from these, by how many depths lie below
/// it.
constexpr std::array<int, kDepth + 1> kFew = {0, 30, 16, 8, 8, 8, 8, 8};

/// `kMap`: the camera is orthographic.
template <bool kMap>
class StripPainter {
 public:
  StripPainter(const SplatFrame& frame, SplatStrip& strip);

  void paint(const SplatTile& tile);

 private:
  hn::Mask<Floats> beside(const SplatFrame::Level& level, Float x, Float y, Float w) const;
  void visit(int depth, TreeChildren children, const Corner& corner);
  bool falls_on_few(const PixelRect& rect, int depth) const {
    const int pixels = (rect.xb - rect.xa + 1) * (rect.yb - rect.ya + 1);
    return pixels <= kFew[static_cast<std::size_t>(tile_->depth - depth)];
  }
  ChildRects project(int depth, const Corner& corner) const;
  Span span(std::size_t row, const SplatFrame::Level& level, Float middle, Float per_w) const;

  const SplatFrame& frame_;
  SplatStrip& strip_;
  PixelPainter<kMap> pixels_;
  const SplatTile* tile_ = nullptr;
  std::array<float, 3> per_w_{};  // What a place is divided by: its z, or, of a map, nothing.
  std::array<float, 4> sides_{};  // Left, right, upper, lower: pixels of the picture,
  std::array<float, 4> reach_{};  // and how far a cube with half an edge of 1 reaches across.
};

template <bool kMap>
StripPainter<kMap>::StripPainter(const SplatFrame& frame, SplatStrip& strip)
    : frame_(frame), strip_(strip), pixels_(frame, strip) {
  sides_ = {static_cast<float>(strip.x0), static_cast<float>(strip.x0 + strip.width), 0,
            static_cast<float>(frame.height)};
  if (!kMap) per_w_ = frame.project[2];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side = 0; side < 4; ++side) {
      reach_[side] += std::abs(frame.project[side / 2][axis] - sides_[side] * per_w_[axis]);
    }
  }
}

template <bool kMap>
void StripPainter<kMap>::paint(const SplatTile& tile) {
  tile_ = &tile;
  pixels_.begin(tile);
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
  const bool deepest = depth == tile_->depth;
  if (!deepest) __builtin_prefetch(tile_->links + children.first / 8);
  const int edge = 1 << (kDepth - depth);
  const ChildRects rects = project(depth, corner);
  const std::uint32_t seen = children.octants & rects.visible;
  if (seen == 0) return;
  const auto& first_met = kFirstMet[pixels_.nearest_octant(corner, edge)];
  for (std::uint32_t left = seen; left != 0;) {
    const std::uint32_t octant = first_met[left];
    left ^= 1u << octant;
    const PixelRect rect{rects.xa[octant], rects.ya[octant], rects.xb[octant], rects.yb[octant]};
    const bool hidden = strip_.coverage.covers(rect);
    if (hidden && strip_.cull) continue;
    const std::uint32_t node = child_at(children, octant);
    const Corner child = child_corner(corner, octant, edge);
    const TreeChildren below = deepest ? TreeChildren{0, 0} : children_of(tile_->links, node);
    if (below.octants == 0) {
      pixels_.draw_cube(child, edge, rect, tile_->first_number + node);
    } else if (!hidden && falls_on_few(rect, depth)) {
      pixels_.cast_rays(depth + 1, below, child, rect);
    } else {
      visit(depth + 1, below, child);
    }
  }
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
