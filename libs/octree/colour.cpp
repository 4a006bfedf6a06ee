#include "octree/colour.hpp"

#include <algorithm>
#include <cstddef>

namespace voxatlas {
namespace {

/// numerator / n to the nearest integer, halves away from zero.
int divide_rounded(int numerator, int n) {
  const int magnitude = ((numerator < 0 ? -numerator : numerator) * 2 + n) / (2 * n);
  return numerator < 0 ? -magnitude : magnitude;
}

std::uint16_t moved(std::uint16_t mean, std::uint8_t seen, int n) {
  return static_cast<std::uint16_t>(mean + divide_rounded(256 * seen - mean, n));
}

}  // namespace

void Colour::add(Rgb seen) {
  count = std::min<std::uint16_t>(static_cast<std::uint16_t>(count + 1), kMaxCount);
  mean = {moved(mean[0], seen.r, count), moved(mean[1], seen.g, count),
          moved(mean[2], seen.b, count)};
}

}  // namespace voxatlas
