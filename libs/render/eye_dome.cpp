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
constexpr std::array<EyeDome::Step, 4> kPairs = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
constexpr float kMostShade = kMostOfOnePair * kPairs.size() * kReach.size();
constexpr float kStepsPerShade = EyeDome::kSteps / kMostShade;

}  // namespace

EyeDome::EyeDome(const CellImage& image, float roughness) : image_(image), roughness_(roughness) {
  for (std::size_t i = 0; i < by_shade_.size(); ++i) {
    by_shade_[i] =
        std::max(kDarkest, std::exp(-kStrength / kStepsPerShade * static_cast<float>(i)));
  }
}

/// Adds to `shade` how far each pixel of row y lies behind the mean of two opposite neighbours,
/// as a part of its depth. Sky, and pixels whose pair leaves the picture, get nothing.
void EyeDome::add_pair(int y, Step step, const float* inverse, float* shade) const {
  const int margin = std::abs(step.dx);
  if (y - std::abs(step.dy) < 0 || y + std::abs(step.dy) >= image_.height) return;
  const std::ptrdiff_t offset = std::ptrdiff_t{step.dy} * image_.width + step.dx;
  const float* z = image_.z.data() + image_.index(0, y);
  const float* w = inverse;
  const float roughness = roughness_;
  for (int x = margin; x < image_.width - margin; ++x) {
    const float before = (0.5f * (w[x + offset] + w[x - offset]) - w[x]) * z[x] - roughness * w[x];
    const float some = before > 0 ? before : 0.0f;  // Sky: not a number, so nothing.
    shade[x] += some < kMostOfOnePair ? some : kMostOfOnePair;
  }
}

void EyeDome::light(int first, int last, Band& band) const {
  const int above = std::max(0, first - kReach.back());
  const int below = std::min(image_.height, last + kReach.back());
  band.first_ = first;
  band.width_ = static_cast<std::size_t>(image_.width);
  band.light_.assign(static_cast<std::size_t>(last - first) * band.width_, 0.0f);
  band.inverse_.resize(static_cast<std::size_t>(below - above) * band.width_);
  const float* from = image_.z.data() + image_.index(0, above);
  std::transform(from, from + band.inverse_.size(), band.inverse_.begin(),
                 [](float z) { return 1.0f / z; });  // Sky: 1 / infinity is 0.
  for (int y = first; y < last; ++y) {
    float* light = band.light_.data() + static_cast<std::size_t>(y - first) * band.width_;
    const float* inverse = band.inverse_.data() + static_cast<std::size_t>(y - above) * band.width_;
    for (const int reach : kReach) {
      for (const Step pair : kPairs) {
        add_pair(y, {pair.dx * reach, pair.dy * reach}, inverse, light);
      }
    }
    const float* z = image_.z.data() + image_.index(0, y);
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
