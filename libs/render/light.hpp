#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>

#include "octree/colour.hpp"

namespace voxatlas {

/// A colour under light: each channel times it, 0..1. In whole numbers: floats take twice as long.
inline Rgb lit(Rgb colour, float light) {
  const auto share = static_cast<std::uint32_t>(light * 65'536 + 0.5f);
  const auto channel = [share](std::uint8_t x) {
    return static_cast<std::uint8_t>((x * share + 32'768) >> 16);
  };
  return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

/// East where up is so, of length 1; at the poles any way along the ground.
Eigen::Vector3d east_of(const Eigen::Vector3d& up_ecef);

/// What falls on a surface of cells from a high sun in the south-east; surfaces turned from it keep
/// half their light.
class Sun {
 public:
  explicit Sun(const Eigen::Vector3d& up_ecef);

  /// On a surface with this normal of length 1, either way round, which is seen along `sight`;
  /// without a normal (zero) an even light.
  float on(const Eigen::Vector3f& normal, const Eigen::Vector3f& sight) const {
    if (normal.isZero(0)) return kWithoutNormal;
    // The side that is seen. No branch: which way round a normal is nobody foresees.
    const float seen = normal.dot(direction_) * std::copysign(1.0f, -normal.dot(sight));
    return kShade + (1 - kShade) * (0.5f + 0.5f * seen);
  }

 private:
  static constexpr float kWithoutNormal = 0.8f;
  static constexpr float kShade = 0.35f;
  Eigen::Vector3f direction_;
};

/// By the sine of the angle above the horizon.
Rgb sky_colour(double sine);

/// The same in steps of 1/500, so that a pixel costs a look.
class SkyColours {
 public:
  SkyColours();
  Rgb at(float sine) const { return table_[static_cast<std::size_t>((sine + 1) * kSteps + 0.5f)]; }

 private:
  static constexpr int kSteps = 500;
  std::array<Rgb, 2 * kSteps + 2> table_{};
};

}  // namespace voxatlas
