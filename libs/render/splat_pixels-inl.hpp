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

#include "render/splat_kernels.hpp"
#include "render/splat_lanes-inl.hpp"
#include "render/splat_rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

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

/// The children of a node, which have this depth and edge, for rays to meet.
struct RayTarget {
  int depth, edge;
  TreeChildren children;
  Corner corner;
  Faces faces;
  const std::uint8_t* first_met;  ///< As in kFirstMet.
};

std::uint32_t child_at(TreeChildren children, std::uint32_t octant) {
  return children.first +
         static_cast<std::uint32_t>(std::popcount(children.octants & ((1u << octant) - 1)));
}

Corner child_corner(const Corner& corner, std::uint32_t octant, int edge) {
  return {corner[0] + (octant & 1 ? edge : 0), corner[1] + (octant & 2 ? edge : 0),
          corner[2] + (octant & 4 ? edge : 0)};
}

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
  SplatRow& row_at(int y);
  std::uint64_t draw_row(SplatRow& row, std::uint64_t pixels, std::uint32_t number) const;
  Faces faces_of(const Corner& corner, int edge) const;
  void clip(std::size_t axis, Float low, Float high, Float ray, Float& in, Float& out) const;
  std::uint32_t meet(const Faces& faces, const SplatRow& row, std::size_t x,
                     std::array<float, 8>& entry) const;
  RayTarget target_of(int depth, TreeChildren children, const Corner& corner) const {
    const int edge = 1 << (kDepth - depth);
    return {depth,
            edge,
            children,
            corner,
            faces_of(corner, edge),
            kFirstMet[nearest_octant(corner, edge)].data()};
  }
  bool cast_at_cells(const RayTarget& cells, SplatRow& row, std::size_t x) const;
  bool cast_at_nodes(const RayTarget& nodes, SplatRow& row, std::size_t x) const;

  const SplatFrame& frame_;
  SplatStrip& strip_;
  const SplatTile* tile_ = nullptr;
  std::uint32_t backwards_ = 0;          // Of a map: the axes down which its rays go.
  std::array<float, 3> low_{}, high_{};  // The faces of the cube being drawn.
};

template <bool kMap>
SplatRow& PixelPainter<kMap>::row_at(int y) {
  const int band = y / SplatStrip::kBand;
  if (std::uint8_t& begun = strip_.begun[static_cast<std::size_t>(band)]; begun == 0) {
    begun = 1;
    begin_band<kMap>(frame_, strip_, band);
  }
  return strip_.rows[static_cast<std::size_t>(y)];
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

/// The slab test, along one axis: what of a ray, from `in` to `out`, lies between two planes.
template <bool kMap>
HWY_INLINE void PixelPainter<kMap>::clip(std::size_t axis, Float low, Float high, Float ray,
                                         Float& in, Float& out) const {
  const Float inverse = kMap ? all(frame_.map_inverse[axis]) : ray;
  if constexpr (kMap) {
    low = hn::Sub(low, ray);
    high = hn::Sub(high, ray);
  }
  const Float a = hn::Mul(low, inverse), b = hn::Mul(high, inverse);
  in = hn::Max(in, hn::Min(a, b));
  out = hn::Min(out, hn::Max(a, b));
}

/// Which of the children a pixel's ray meets, and where it enters them.
template <bool kMap>
HWY_INLINE std::uint32_t PixelPainter<kMap>::meet(const Faces& faces, const SplatRow& row,
                                                  std::size_t x,
                                                  std::array<float, 8>& entry) const {
  std::uint32_t met = 0;
  for (std::size_t i = 0; i < 8; i += hn::Lanes(kFloats)) {
    Float in = all(frame_.near_z), out = all(frame_.far_z);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Float ray = all(row.ray[axis][x]);
      const Float low = hn::Load(kFloats, faces.low[axis].data() + i);
      const Float high = hn::Load(kFloats, faces.high[axis].data() + i);
      clip(axis, low, high, ray, in, out);
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
  const RayTarget target = target_of(depth, children, corner);
  const std::uint64_t columns = Coverage::columns(rect);
  const bool cells = depth == tile_->depth;
  for (int y = rect.ya; y <= rect.yb; ++y) {
    std::uint64_t open = strip_.coverage.open(y, columns), met = 0;
    if (open == 0) continue;
    SplatRow& row = row_at(y);
    for (; open != 0; open &= open - 1) {
      const auto x = static_cast<std::size_t>(std::countr_zero(open));
      const bool meets = cells ? cast_at_cells(target, row, x) : cast_at_nodes(target, row, x);
      if (meets) met |= open & -open;
    }
    strip_.coverage.draw(y, met);
  }
}

/// Whether the ray of a pixel meets any of these cells. If so, the pixel shows it.
template <bool kMap>
HWY_INLINE bool PixelPainter<kMap>::cast_at_cells(const RayTarget& cells, SplatRow& row,
                                                  std::size_t x) const {
  std::array<float, 8> entry;
  const std::uint32_t met = cells.children.octants & meet(cells.faces, row, x, entry);
  if (met == 0) return false;
  const std::uint32_t octant = cells.first_met[met];
  row.z[x] = entry[octant] * frame_.voxel_metres;
  row.cell[x] = tile_->first_number + child_at(cells.children, octant);
  return true;
}

/// The same of all below these nodes.
template <bool kMap>
bool PixelPainter<kMap>::cast_at_nodes(const RayTarget& nodes, SplatRow& row, std::size_t x) const {
  std::array<float, 8> entry;
  for (std::uint32_t left = nodes.children.octants & meet(nodes.faces, row, x, entry); left != 0;) {
    const std::uint32_t octant = nodes.first_met[left];
    left ^= 1u << octant;
    const std::uint32_t node = child_at(nodes.children, octant);
    const TreeChildren below = children_of(tile_->links, node);
    if (below.octants == 0) {
      row.z[x] = entry[octant] * frame_.voxel_metres;
      row.cell[x] = tile_->first_number + node;
      return true;
    }
    const RayTarget target =
        target_of(nodes.depth + 1, below, child_corner(nodes.corner, octant, nodes.edge));
    const bool cells = target.depth == tile_->depth;
    if (cells ? cast_at_cells(target, row, x) : cast_at_nodes(target, row, x)) return true;
  }
  return false;
}

/// Exactly the pixels whose ray meets the cube. Neighbours share their faces to the bit, so no ray
/// slips between them.
template <bool kMap>
void PixelPainter<kMap>::draw_cube(const Corner& corner, int edge, const PixelRect& where,
                                   std::uint32_t number) {
  constexpr int kLarge = 24;  // Pixels.
  const bool large = where.xb - where.xa > kLarge || where.yb - where.ya > kLarge;
  const PixelRect rect = large ? frame_.tightened(corner, edge, where, strip_.x0) : where;
  if (rect.xa > rect.xb || rect.ya > rect.yb) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low_[axis] = static_cast<float>(corner[axis]) - frame_.in_voxel[axis];
    high_[axis] = static_cast<float>(corner[axis] + edge) - frame_.in_voxel[axis];
  }
  const std::uint64_t columns = Coverage::columns(rect);
  for (int y = rect.ya; y <= rect.yb; ++y) {
    const std::uint64_t open = strip_.coverage.open(y, columns);
    if (open != 0) strip_.coverage.draw(y, draw_row(row_at(y), open, number));
  }
}

template <bool kMap>
std::uint64_t PixelPainter<kMap>::draw_row(SplatRow& row, std::uint64_t pixels,
                                           std::uint32_t number) const {
  constexpr std::size_t kWidth = Coverage::kWidth;
  const std::size_t lanes = hn::Lanes(kFloats);
  std::uint64_t met = 0;
  while (pixels != 0) {
    const auto x = std::min(static_cast<std::size_t>(std::countr_zero(pixels)), kWidth - lanes);
    const auto open = static_cast<std::uint32_t>(pixels >> x) & ((1u << lanes) - 1);
    pixels &= ~(std::uint64_t{open} << x);
    Float in = all(frame_.near_z), out = all(frame_.far_z);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Float ray = hn::LoadU(kFloats, row.ray[axis].data() + x);
      clip(axis, all(low_[axis]), all(high_[axis]), ray, in, out);
    }
    const auto hit = hn::And(hn::Le(in, out), mask_of(open));
    met |= std::uint64_t{bits_of(hit)} << x;
    hn::BlendedStore(hn::Mul(in, all(frame_.voxel_metres)), hit, kFloats, row.z.data() + x);
    hn::BlendedStore(hn::Set(kWords, number), hn::RebindMask(kWords, hit), kWords,
                     row.cell.data() + x);
  }
  return met;
}

}  // namespace
}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
