// Highway includes this once for each set of instructions.
#if defined(VOX_SPLAT_PIXELS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef VOX_SPLAT_PIXELS_INL_HPP
#undef VOX_SPLAT_PIXELS_INL_HPP
#else
#define VOX_SPLAT_PIXELS_INL_HPP
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>

#include "render/cell_image.hpp"
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

/// Of a node's children, by axis: between which planes they lie. A lane an octant.
struct Faces {
  alignas(64) std::array<std::array<float, 8>, 3> low, high;
};

/// Of a set of octants, the one met first by rays that come from octant `nearest`.
constexpr auto kFirstMet = [] {
  std::array<std::array<std::uint8_t, 256>, 8> first{};
  for (std::uint32_t nearest = 0; nearest < 8; ++nearest) {
    for (std::uint32_t octants = 1; octants < 256; ++octants) {
      std::uint32_t step = 0;
      while ((octants & 1u << (step ^ nearest)) == 0) ++step;
      first[nearest][octants] = static_cast<std::uint8_t>(step ^ nearest);
    }
  }
  return first;
}();

/// Finds which pixels of a strip show a cell, by the slab test: pixels a lane where a cell falls on
/// many of them, cells a lane where a node with all its cells falls on few. `kMap`: the camera is
/// orthographic.
template <bool kMap>
class PixelPainter {
 public:
  PixelPainter(const SplatFrame& frame, SplatStrip& strip) : frame_(frame), strip_(strip) {
    for (std::size_t axis = 0; axis < 3 && kMap; ++axis) {
      backwards_ |= (frame.ray[axis] < 0 ? 1u : 0u) << axis;
    }
  }
  void begin(const SplatTile& tile) { tile_ = &tile; }

  /// The octant on the eye's side of each middle plane of a node whose children have this edge.
  std::uint32_t nearest_octant(const Corner& corner, int edge) const;
  /// A cell, on pixels of the rect.
  void draw_cube(const Corner& corner, int edge, const PixelRect& rect, std::uint32_t number);
  /// All below a node, on pixels of the rect; the children have this depth.
  void cast_rays(int depth, TreeChildren children, const Corner& corner, const PixelRect& rect);

 private:
  SplatBlock& block_at(int bx, int by);
  void begin(SplatBlock& block, int bx, int by) const;
  std::uint64_t draw_rows(SplatBlock& block, std::uint64_t pixels, std::uint32_t number) const;
  std::uint64_t draw_pixels(SplatBlock& block, std::uint64_t pixels, std::uint32_t number) const;
  Faces faces_of(const Corner& corner, int edge) const;
  std::uint32_t meet(const Faces& faces, const SplatBlock& block, std::size_t pixel,
                     std::array<float, 8>& entry) const;
  std::uint64_t cast(int depth, TreeChildren children, const Corner& corner, SplatBlock& block,
                     std::uint64_t pixels) const;
  std::uint64_t cast_at_cells(TreeChildren cells, const Corner& corner, int edge, SplatBlock& block,
                              std::uint64_t pixels) const;

  const SplatFrame& frame_;
  SplatStrip& strip_;
  const SplatTile* tile_ = nullptr;
  std::uint32_t backwards_ = 0;          // Of a map: the axes down which its rays go.
  std::array<float, 3> low_{}, high_{};  // The faces of the cube being drawn.
};

/// What a block holds before the first cell that comes near it is drawn.
template <bool kMap>
SplatBlock& PixelPainter<kMap>::block_at(int bx, int by) {
  const std::size_t index = strip_.coverage.block_index(bx, by);
  SplatBlock& block = strip_.blocks[index];
  if (strip_.begun[index] == 0) {
    strip_.begun[index] = 1;
    begin(block, bx, by);
  }
  return block;
}

/// A ray is taken from the middle of its block, in double, and a few small steps: so that one that
/// is all but parallel to a face keeps its digits.
template <bool kMap>
HWY_NOINLINE void PixelPainter<kMap>::begin(SplatBlock& block, int bx, int by) const {
  const double left = strip_.x0 + bx * 8, top = by * 8;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float* const out = block.ray[axis].data();
    if constexpr (kMap) {
      for (std::size_t pixel = 0; pixel < 64; ++pixel) {
        const double x = left + static_cast<double>(pixel % 8) + 0.5;
        const double y = top + static_cast<double>(pixel / 8) + 0.5;
        out[pixel] = static_cast<float>(frame_.start[axis] + x * frame_.start_dx[axis] +
                                        y * frame_.start_dy[axis]);
      }
      continue;
    }
    const auto middle = static_cast<float>(frame_.ray[axis] + (left + 4) * frame_.ray_dx[axis] +
                                           (top + 4) * frame_.ray_dy[axis]);
    const auto dx = static_cast<float>(frame_.ray_dx[axis]);
    const auto dy = static_cast<float>(frame_.ray_dy[axis]);
    for (std::size_t row = 0; row < 8; ++row) {
      const Float start = all(middle + (static_cast<float>(row) - 3.5f) * dy);
      for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
        const Float column = hn::Iota(kFloats, static_cast<float>(i) - 3.5f);
        const Float ray = hn::Add(start, hn::Mul(column, all(dx)));
        const Float tiny = hn::CopySign(all(SplatFrame::kTinyRay), ray);
        const auto along = hn::Lt(hn::Abs(ray), all(SplatFrame::kTinyRay));
        hn::Store(hn::Div(all(1), hn::IfThenElse(along, tiny, ray)), kFloats, out + row * 8 + i);
      }
    }
  }
  block.cell.fill(CellImage::kNone);
  block.z.fill(CellImage::kNowhere);
}

template <bool kMap>
std::uint32_t PixelPainter<kMap>::nearest_octant(const Corner& corner, int edge) const {
  std::uint32_t nearest = backwards_;
  for (std::size_t axis = 0; axis < 3 && !kMap; ++axis) {
    nearest |= (corner[axis] + edge <= 0 ? 1u : 0u) << axis;
  }
  return nearest;
}

template <bool kMap>
Faces PixelPainter<kMap>::faces_of(const Corner& corner, int edge) const {
  constexpr std::array<std::uint32_t, 3> kUpper = {0xaa, 0xcc, 0xf0};  // Octants, by axis.
  Faces faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<float, 3> plane;
    for (int i = 0; i < 3; ++i) {
      plane[static_cast<std::size_t>(i)] =
          static_cast<float>(corner[axis] + i * edge) - frame_.in_voxel[axis];
    }
    for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
      const auto upper = mask_of(kUpper[axis] >> i);
      hn::Store(hn::IfThenElse(upper, all(plane[1]), all(plane[0])), kFloats,
                faces.low[axis].data() + i);
      hn::Store(hn::IfThenElse(upper, all(plane[2]), all(plane[1])), kFloats,
                faces.high[axis].data() + i);
    }
  }
  return faces;
}

/// Which of the children a pixel's ray meets, and where it enters them.
template <bool kMap>
std::uint32_t PixelPainter<kMap>::meet(const Faces& faces, const SplatBlock& block,
                                       std::size_t pixel, std::array<float, 8>& entry) const {
  std::uint32_t met = 0;
  for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
    Float in = all(frame_.near_z), out = all(frame_.far_z);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Float ray = all(block.ray[axis][pixel]);
      const Float inverse = kMap ? all(frame_.map_inverse[axis]) : ray;
      Float low = hn::Load(kFloats, faces.low[axis].data() + i);
      Float high = hn::Load(kFloats, faces.high[axis].data() + i);
      if constexpr (kMap) {
        const Float start = ray;
        low = hn::Sub(low, start);
        high = hn::Sub(high, start);
      }
      const Float a = hn::Mul(low, inverse), b = hn::Mul(high, inverse);
      in = hn::Max(in, hn::Min(a, b));
      out = hn::Min(out, hn::Max(a, b));
    }
    hn::StoreU(in, kFloats, entry.data() + i);
    met |= bits_of(hn::Le(in, out)) << i;
  }
  return met;
}

/// The children of a node of this depth that falls on few pixels: these look for what they meet.
template <bool kMap>
void PixelPainter<kMap>::cast_rays(int depth, TreeChildren children, const Corner& corner,
                                   const PixelRect& rect) {
  Coverage& coverage = strip_.coverage;
  for (int by = rect.ya >> 3; by <= rect.yb >> 3; ++by) {
    for (int bx = rect.xa >> 3; bx <= rect.xb >> 3; ++bx) {
      const std::uint64_t open =
          Coverage::within(rect, bx, by) & ~coverage.drawn(coverage.block_index(bx, by));
      if (open == 0) continue;
      const std::uint64_t met = cast(depth, children, corner, block_at(bx, by), open);
      if (met != 0) coverage.draw(bx, by, met);
    }
  }
}

template <bool kMap>
std::uint64_t PixelPainter<kMap>::cast(int depth, TreeChildren children, const Corner& corner,
                                       SplatBlock& block, std::uint64_t pixels) const {
  const int edge = 1 << (kDepth - depth);
  if (depth == tile_->depth) return cast_at_cells(children, corner, edge, block, pixels);
  const Faces faces = faces_of(corner, edge);
  const auto& first_met = kFirstMet[nearest_octant(corner, edge)];
  std::array<float, 8> entry;
  std::uint64_t met = 0;
  for (; pixels != 0; pixels &= pixels - 1) {
    const auto at = static_cast<std::size_t>(std::countr_zero(pixels));
    const std::uint64_t pixel = pixels & -pixels;
    for (std::uint32_t left = children.octants & meet(faces, block, at, entry); left != 0;) {
      const std::uint32_t octant = first_met[left];
      left ^= 1u << octant;
      const std::uint32_t node =
          children.first +
          static_cast<std::uint32_t>(std::popcount(children.octants & ((1u << octant) - 1)));
      if (const auto below = children_of(tile_->links, node); below.octants != 0) {
        const Corner child{corner[0] + (octant & 1 ? edge : 0), corner[1] + (octant & 2 ? edge : 0),
                           corner[2] + (octant & 4 ? edge : 0)};
        if (cast(depth + 1, below, child, block, pixel) == 0) continue;
        met |= pixel;
        break;
      }
      block.z[at] = entry[octant] * frame_.voxel_metres;
      block.cell[at] = tile_->first_number + node;
      met |= pixel;
      break;
    }
  }
  return met;
}

/// The children are drawn whole: the first that a ray meets is what its pixel shows.
template <bool kMap>
std::uint64_t PixelPainter<kMap>::cast_at_cells(TreeChildren cells, const Corner& corner, int edge,
                                                SplatBlock& block, std::uint64_t pixels) const {
  const Faces faces = faces_of(corner, edge);
  const auto& first_met = kFirstMet[nearest_octant(corner, edge)];
  const std::uint32_t number = tile_->first_number + cells.first;
  const float metres = frame_.voxel_metres;
  std::array<float, 8> entry;
  std::uint64_t met = 0;
  for (; pixels != 0; pixels &= pixels - 1) {
    const auto pixel = static_cast<std::size_t>(std::countr_zero(pixels));
    const std::uint32_t hit = cells.octants & meet(faces, block, pixel, entry);
    if (hit == 0) continue;
    const std::uint32_t octant = first_met[hit];
    block.cell[pixel] =
        number + static_cast<std::uint32_t>(std::popcount(cells.octants & ((1u << octant) - 1)));
    block.z[pixel] = entry[octant] * metres;
    met |= pixels & -pixels;
  }
  return met;
}

/// Exactly the pixels whose ray meets the cube. Neighbours share their faces to the bit, so no ray
/// slips between them.
template <bool kMap>
void PixelPainter<kMap>::draw_cube(const Corner& corner, int edge, const PixelRect& where,
                                   std::uint32_t number) {
  constexpr int kLarge = 3 * Coverage::kBlock;
  const bool large = where.xb - where.xa > kLarge || where.yb - where.ya > kLarge;
  const PixelRect rect = large ? frame_.tightened(corner, edge, where, strip_.x0) : where;
  if (rect.xa > rect.xb || rect.ya > rect.yb) return;
  bool faced = false;
  Coverage& coverage = strip_.coverage;
  for (int by = rect.ya >> 3; by <= rect.yb >> 3; ++by) {
    for (int bx = rect.xa >> 3; bx <= rect.xb >> 3; ++bx) {
      const std::uint64_t open =
          Coverage::within(rect, bx, by) & ~coverage.drawn(coverage.block_index(bx, by));
      if (open == 0) continue;
      for (std::size_t axis = 0; axis < 3 && !faced; ++axis) {
        low_[axis] = static_cast<float>(corner[axis]) - frame_.in_voxel[axis];
        high_[axis] = static_cast<float>(corner[axis] + edge) - frame_.in_voxel[axis];
      }
      faced = true;
      constexpr int kFew = 3;
      SplatBlock& block = block_at(bx, by);
      const std::uint64_t met = std::popcount(open) <= kFew ? draw_pixels(block, open, number)
                                                            : draw_rows(block, open, number);
      if (met != 0) coverage.draw(bx, by, met);
    }
  }
}

template <bool kMap>
std::uint64_t PixelPainter<kMap>::draw_rows(SplatBlock& block, std::uint64_t pixels,
                                            std::uint32_t number) const {
  std::uint64_t met = 0;
  const std::size_t lanes = hn::Lanes(kFloats);
  for (int row = std::countr_zero(pixels) / 8; row * 8 < 64 - std::countl_zero(pixels); ++row) {
    for (std::size_t i = 0; i < 8; i += lanes) {
      const std::size_t at = static_cast<std::size_t>(row) * 8 + i;
      const auto open = static_cast<std::uint32_t>(pixels >> at & 0xff) & ((1u << lanes) - 1);
      if (open == 0) continue;
      Float in = all(frame_.near_z), out = all(frame_.far_z);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Float ray = hn::Load(kFloats, block.ray[axis].data() + at);
        const Float inverse = kMap ? all(frame_.map_inverse[axis]) : ray;
        Float low = all(low_[axis]), high = all(high_[axis]);
        if constexpr (kMap) {
          const Float start = ray;
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
      met |= std::uint64_t{hits} << at;
      hn::BlendedStore(hn::Mul(in, all(frame_.voxel_metres)), hit, kFloats, block.z.data() + at);
      hn::BlendedStore(hn::Set(kWords, number), hn::RebindMask(kWords, hit), kWords,
                       block.cell.data() + at);
    }
  }
  return met;
}

/// The same, one by one: cheaper where there are few.
template <bool kMap>
std::uint64_t PixelPainter<kMap>::draw_pixels(SplatBlock& block, std::uint64_t pixels,
                                              std::uint32_t number) const {
  std::uint64_t met = 0;
  for (; pixels != 0; pixels &= pixels - 1) {
    const auto at = static_cast<std::size_t>(std::countr_zero(pixels));
    float in = frame_.near_z, out = frame_.far_z;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float ray = block.ray[axis][at], start = kMap ? ray : 0;
      const float inverse = kMap ? frame_.map_inverse[axis] : ray;
      const float a = (low_[axis] - start) * inverse, b = (high_[axis] - start) * inverse;
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    if (!(in <= out)) continue;
    met |= pixels & -pixels;
    block.z[at] = in * frame_.voxel_metres;
    block.cell[at] = number;
  }
  return met;
}

}  // namespace
}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
