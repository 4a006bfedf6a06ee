#include "render/eye_dome_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/eye_dome_rows.cpp"
#include <hwy/foreach_target.h>
// Highway includes this file once for each set of instructions; so first itself, then the others.
#include <hwy/highway.h>

#include <algorithm>

#include "render/eye_dome_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace voxatlas::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using OneFloat = hn::CappedTag<float, 1>;

template <class Tag>
void invert_at(Tag tag, const float* z, float* inverse) {
  hn::StoreU(hn::Div(hn::Set(tag, 1.0f), hn::LoadU(tag, z)), tag, inverse);
}

void invert(const float* z, std::size_t count, float* inverse) {
  constexpr Floats kFloats;
  std::size_t i = 0;
  for (; i + hn::Lanes(kFloats) <= count; i += hn::Lanes(kFloats)) {
    invert_at(kFloats, z + i, inverse + i);
  }
  for (; i < count; ++i) invert_at(OneFloat(), z + i, inverse + i);
}

struct Row {
  const float *z, *inverse;
  int width;
  std::span<const EyeDomePair> pairs;
  float roughness, most;
};

/// Pixels from x on, all of which have the pairs that have any of `reached` pixels at a row's end.
template <class Tag>
void sum_at(Tag tag, const Row& row, int x, int reached, float* shades) {
  const auto z = hn::LoadU(tag, row.z + x), inverse = hn::LoadU(tag, row.inverse + x);
  const auto rough = hn::Mul(hn::Set(tag, row.roughness), inverse);
  auto sum = hn::Zero(tag);
  for (const auto& [offset, margin] : row.pairs) {
    if (margin > reached) continue;
    const float* middle = row.inverse + x;
    const auto mean = hn::Mul(hn::Set(tag, 0.5f), hn::Add(hn::LoadU(tag, middle + offset),
                                                          hn::LoadU(tag, middle - offset)));
    const auto before = hn::Sub(hn::Mul(hn::Sub(mean, inverse), z), rough);
    // Between sky and sky: not a number, so nothing.
    const auto some = hn::IfThenElseZero(hn::Gt(before, hn::Zero(tag)), before);
    sum = hn::Add(sum, hn::Min(some, hn::Set(tag, row.most)));
  }
  hn::StoreU(sum, tag, shades + x);
}

void sum_row(const Row& row, float* shades) {
  constexpr Floats kFloats;
  const int lanes = static_cast<int>(hn::Lanes(kFloats));
  int widest = 0;
  for (const auto& pair : row.pairs) widest = std::max(widest, pair.margin);
  int x = 0;
  const auto one = [&] {
    sum_at(OneFloat(), row, x, std::min(x, row.width - 1 - x), shades);
    ++x;
  };
  while (x < std::min(widest, row.width)) one();
  for (; x + lanes <= row.width - widest; x += lanes) sum_at(kFloats, row, x, widest, shades);
  while (x < row.width) one();
}

}  // namespace

void invert_row(const float* z, std::size_t count, float* inverse) { invert(z, count, inverse); }

void sum_row_shades(const float* z, const float* inverse, int width,
                    std::span<const EyeDomePair> pairs, float roughness, float most,
                    float* shades) {
  sum_row({z, inverse, width, pairs, roughness, most}, shades);
}

}  // namespace voxatlas::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace voxatlas {

HWY_EXPORT(invert_row);
HWY_EXPORT(sum_row_shades);

void invert_depths(const float* z, std::size_t count, float* inverse) {
  HWY_DYNAMIC_DISPATCH(invert_row)(z, count, inverse);
}

void sum_shades(const float* z, const float* inverse, int width, std::span<const EyeDomePair> pairs,
                float roughness, float most, float* shades) {
  HWY_DYNAMIC_DISPATCH(sum_row_shades)(z, inverse, width, pairs, roughness, most, shades);
}

}  // namespace voxatlas
#endif
