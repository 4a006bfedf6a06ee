#include "render/eye_dome_rows.hpp"

#include <hwy/targets.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

constexpr float kSky = std::numeric_limits<float>::infinity();

float shade_of(float z, const float* inverse, int x, int width, std::span<const EyeDomePair> pairs,
               float roughness, float most) {
  float sum = 0;
  for (const auto& [offset, margin] : pairs) {
    if (x < margin || x >= width - margin) continue;
    const float mean = 0.5f * (inverse[x + offset] + inverse[x - offset]);
    const float before = (mean - inverse[x]) * z - roughness * inverse[x];
    sum += std::min(before > 0 ? before : 0, most);
  }
  return sum;
}

TEST_CASE("each set of instructions sums a row's shades to the same bits", "[eye_dome][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<float> depth(0.5f, 200);
  const std::int64_t all_targets = hwy::SupportedTargets();
  for (const int width : {1, 2, 3, 7, 8, 9, 31, 40, 131}) {
    constexpr int kRows = 9, kMiddle = 4;
    const auto count = static_cast<std::size_t>(width * kRows);
    std::vector<float> z(count), inverse(count), shades(static_cast<std::size_t>(width));
    for (float& metres : z) metres = rng() % 5 == 0 ? kSky : depth(rng);
    std::vector<EyeDomePair> pairs;
    for (const int reach : {1, 4}) {
      pairs.push_back({reach, reach});
      pairs.push_back({reach * width, 0});
      pairs.push_back({reach * width + reach, reach});
      pairs.push_back({reach - reach * width, reach});
    }
    for (std::int64_t left = all_targets; left != 0; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      hwy::GetChosenTarget().DeInit();
      invert_depths(z.data(), count, inverse.data());
      const float* row = inverse.data() + kMiddle * width;
      sum_shades(z.data() + kMiddle * width, row, width, pairs, 0.1f, 0.04f, shades.data());
      for (std::size_t i = 0; i < count; ++i) REQUIRE(inverse[i] == 1 / z[i]);
      for (int x = 0; x < width; ++x) {
        const float own = z[static_cast<std::size_t>(kMiddle * width + x)];
        REQUIRE(shades[static_cast<std::size_t>(x)] ==
                shade_of(own, row, x, width, pairs, 0.1f, 0.04f));
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
}

}  // namespace
}  // namespace voxatlas
