// Highway includes this once for each set of instructions.
#if defined(VOX_SPLAT_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef VOX_SPLAT_LANES_INL_HPP
#undef VOX_SPLAT_LANES_INL_HPP
#else
#define VOX_SPLAT_LANES_INL_HPP
#endif

#include <hwy/highway.h>

#include <array>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Eight floats: the children of a node, pixels side by side. They are one register, or two or
/// eight where registers are shorter.
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

}  // namespace
}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
