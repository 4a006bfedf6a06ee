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
constexpr float kMostShade = kMostOfOnePair * kPairs.size() * kReach.size();
constexpr float kStepsPerShade = EyeDome::kSteps / kMostShade;

}  // namespace

EyeDome::EyeDome(const CellImage& image, float roughness) : image_(image), roughness_(roughness) {
  for (std::size_t i = 0; i < by_shade_.size(); ++i) {
    by_shade_[i] =
        std::max(kDarkest, std::exp(-kStrength / kStepsPerShade * static_cast<float>(i)));
  }
}

/// Of row y: the pairs that lie within the picture.
std::size_t EyeDome::pairs_of(int y, std::span<EyeDomePair> pairs) const {
  std::size_t count = 0;
  for (const int reach : kReach) {
    for (const auto& [dx, dy] : kPairs) {
      const int up = std::abs(dy * reach);
      if (y - up < 0 || y + up >= image_.height) continue;
      pairs[count++] = {std::ptrdiff_t{dy * reach} * image_.width + dx * reach,
                        std::abs(dx * reach)};
    }
  }
  return count;
}

void EyeDome::light(int first, int last, Band& band) const {
  const int above = std::max(0, first - kReach.back());
  const int below = std::min(image_.height, last + kReach.back());
  band.first_ = first;
  band.width_ = static_cast<std::size_t>(image_.width);
  band.light_.resize(static_cast<std::size_t>(last - first) * band.width_);
  band.inverse_.resize(static_cast<std::size_t>(below - above) * band.width_);
  invert_depths(image_.z.data() + image_.index(0, above), band.inverse_.size(),
                band.inverse_.data());
  std::array<EyeDomePair, kPairs.size() * kReach.size()> pairs;
  for (int y = first; y < last; ++y) {
    float* light = band.light_.data() + static_cast<std::size_t>(y - first) * band.width_;
    const float* inverse = band.inverse_.data() + static_cast<std::size_t>(y - above) * band.width_;
    const float* z = image_.z.data() + image_.index(0, y);
    sum_shades(z, inverse, image_.width, {pairs.data(), pairs_of(y, pairs)}, roughness_,
               kMostOfOnePair, light);
    for (std::size_t x = 0; x < band.width_; ++x) {
      light[x] = z[x] == CellImage::kNowhere
                     ? 1.0f
                     : by_shade_[static_cast<std::size_t>(light[x] * kStepsPerShade + 0.5f)];
    }
  }
}

std::vector<float> eye_dome_light(const CellImage& image, float roughness) {
  EyeDome::Band band;
  EyeDome(image, roughness).light(0, image.height, band);
  const auto all = band.row(0);
  return {all.data(), all.data() + image.z.size()};
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
