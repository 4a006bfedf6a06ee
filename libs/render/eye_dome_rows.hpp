#pragma once

#include <cstddef>
#include <span>

namespace voxatlas {

/// Two opposite neighbours of each pixel of a row.
struct EyeDomePair {
  std::ptrdiff_t offset;  ///< Pixels from one to it, and from it to the other.
  int margin;             ///< So many pixels at both ends of a row have no such pair.
};

/// The inner loops of EyeDome. Every set of instructions gives the same bits.
///
/// 1 / z; 0 for infinity.
void invert_depths(const float* z, std::size_t count, float* inverse);

/// For each pixel of a row how far it lies behind the mean of two opposite neighbours, as a part of
/// its depth, less the roughness: 0 .. `most` each, summed over the pairs in their order. Of sky it
/// says nothing. `inverse`: of the row's first pixel, within those of all rows that the pairs
/// reach.
void sum_shades(const float* z, const float* inverse, int width, std::span<const EyeDomePair> pairs,
                float roughness, float most, float* shades);

}  // namespace voxatlas
