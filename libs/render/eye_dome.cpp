#include "render/eye_dome.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace voxatlas {
namespace {

constexpr float kStrength = 12;
constexpr float kMostOfOnePair = 0.04f;  // So that one near leaf does not blacken its surroundings.
constexpr std::array kReach = {1, 4};    // Pixels.

struct Step {
  int dx, dy;
};
constexpr std::array<Step, 4> kPairs = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

std::vector<float> inverse_depths(const CellImage& image) {
  std::vector<float> inverse(image.z.size());
  std::transform(image.z.begin(), image.z.end(), inverse.begin(),
                 [](float z) { return 1.0f / z; });  // Sky: 1 / infinity is 0.
  return inverse;
}

/// Adds to `shade` how far each pixel of row y lies behind the mean of two opposite neighbours,
/// as a part of its depth. Sky, and pixels whose pair leaves the
/// picture, get nothing.
void add_pair(const CellImage& image, const std::vector<float>& inverse, int y, Step step,
              float roughness, std::vector<float>& shade) {
  const int margin = std::abs(step.dx);
  if (y - std::abs(step.dy) < 0 || y + std::abs(step.dy) >= image.height) return;
  const std::ptrdiff_t offset = std::ptrdiff_t{step.dy} * image.width + step.dx;
  const std::size_t row = image.index(0, y);
  for (int x = margin; x < image.width - margin; ++x) {
    const float* w = inverse.data() + row + x;
    const float z = image.z[row + static_cast<std::size_t>(x)];
    const float before = (0.5f * (w[offset] + w[-offset]) - *w) * z - roughness * *w;
    if (before > 0 && *w > 0)
      shade[static_cast<std::size_t>(x)] += std::min(before, kMostOfOnePair);
  }
}

}  // namespace

std::vector<float> eye_dome_light(const CellImage& image, float roughness) {
  const auto inverse = inverse_depths(image);
  std::vector<float> light(image.z.size());
  std::vector<float> shade(static_cast<std::size_t>(image.width));
  for (int y = 0; y < image.height; ++y) {
    std::fill(shade.begin(), shade.end(), 0.0f);
    for (const int reach : kReach) {
      for (const Step pair : kPairs) {
        add_pair(image, inverse, y, {pair.dx * reach, pair.dy * reach}, roughness, shade);
      }
    }
    std::transform(shade.begin(), shade.end(),
                   light.begin() + static_cast<std::ptrdiff_t>(image.index(0, y)),
                   [](float s) { return std::max(kDarkest, std::exp(-kStrength * s)); });
  }
  return light;
}

std::size_t fill_holes(CellImage& image) {
  constexpr float kWellBefore = 0.9f;
  constexpr int kEnough = 6;
  struct Fill {
    std::size_t at;
    std::uint32_t cell;
    float z;
  };
  std::vector<Fill> fills;  // Kept until all are found: a filled hole is nobody's neighbour.
  for (int y = 1; y + 1 < image.height; ++y) {
    for (int x = 1; x + 1 < image.width; ++x) {
      const std::size_t at = image.index(x, y);
      const float limit = image.z[at] * kWellBefore;
      int before = 0;
      std::size_t nearest = at;
      for (int i = 0; i < 9; ++i) {
        const std::size_t other = image.index(x + i % 3 - 1, y + i / 3 - 1);
        if (!(image.z[other] < limit)) continue;
        ++before;
        if (image.z[other] < image.z[nearest]) nearest = other;
      }
      if (before >= kEnough) fills.push_back({at, image.cell[nearest], image.z[nearest]});
    }
  }
  for (const Fill& fill : fills) {
    image.cell[fill.at] = fill.cell;
    image.z[fill.at] = fill.z;
  }
  return fills.size();
}

}  // namespace voxatlas
