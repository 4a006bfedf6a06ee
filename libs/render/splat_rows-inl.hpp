// Highway includes this once for each set of instructions.
#if defined(VOX_SPLAT_ROWS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef VOX_SPLAT_ROWS_INL_HPP
#undef VOX_SPLAT_ROWS_INL_HPP
#else
#define VOX_SPLAT_ROWS_INL_HPP
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "render/cell_image.hpp"
#include "render/splat_kernels.hpp"
#include "render/splat_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

/// 1 / the rays of 8x8 pixels, along an axis. A ray is taken from their middle, in double, and a
/// few small steps: so that one that is all but parallel to a face keeps its digits.
HWY_INLINE void invert_rays(const SplatFrame& frame, SplatStrip& strip, std::size_t axis, int left,
                            int top) {
  static_assert(SplatStrip::kBand == 8);
  const auto middle =
      static_cast<float>(frame.ray[axis] + (strip.x0 + left + 4) * frame.ray_dx[axis] +
                         (top + 4) * frame.ray_dy[axis]);
  const auto dx = static_cast<float>(frame.ray_dx[axis]);
  const auto dy = static_cast<float>(frame.ray_dy[axis]);
  for (int y = 0; y < 8; ++y) {
    const Float row = all(middle + (static_cast<float>(y) - 3.5f) * dy);
    float* const inverse = strip.rows[static_cast<std::size_t>(top + y)].ray[axis].data() + left;
    for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
      const Float steps = hn::Iota(kFloats, static_cast<float>(i) - 3.5f);
      const Float ray = hn::Add(row, hn::Mul(steps, all(dx)));
      const auto along = hn::Lt(hn::Abs(ray), all(SplatFrame::kTinyRay));
      const Float tiny = hn::CopySign(all(SplatFrame::kTinyRay), ray);
      hn::Store(hn::Div(all(1), hn::IfThenElse(along, tiny, ray)), kFloats, inverse + i);
    }
  }
}

/// Where a map's rays start: in the plane through the eye across them.
void place_starts(const SplatFrame& frame, SplatStrip& strip, std::size_t axis, int left, int top) {
  for (int y = top; y < top + 8; ++y) {
    float* const start = strip.rows[static_cast<std::size_t>(y)].ray[axis].data();
    for (int x = left; x < left + 8; ++x) {
      start[x] =
          static_cast<float>(frame.start[axis] + (strip.x0 + x + 0.5) * frame.start_dx[axis] +
                             (y + 0.5) * frame.start_dy[axis]);
    }
  }
}

/// What a band's rows hold before the first cell that comes near them is drawn.
template <bool kMap>
HWY_NOINLINE void begin_band(const SplatFrame& frame, SplatStrip& strip, int band) {
  const int top = band * SplatStrip::kBand;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int left = 0; left < Coverage::kWidth; left += 8) {
      kMap ? place_starts(frame, strip, axis, left, top)
           : invert_rays(frame, strip, axis, left, top);
    }
  }
  for (int y = top; y < top + SplatStrip::kBand; ++y) {
    SplatRow& row = strip.rows[static_cast<std::size_t>(y)];
    row.cell.fill(CellImage::kNone);
    row.z.fill(CellImage::kNowhere);
  }
}

}  // namespace
}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
