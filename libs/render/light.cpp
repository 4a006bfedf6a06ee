#include "render/light.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace voxatlas {
namespace {

Rgb mix(Rgb a, Rgb b, double t) {
  const auto channel = [t](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>(std::lround(x + t * (y - x)));
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

}  // namespace

Eigen::Vector3d east_of(const Eigen::Vector3d& up_ecef) {
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(up_ecef);
  return across.norm() > 1e-9 ? across.normalized() : up_ecef.unitOrthogonal();
}

Sun::Sun(const Eigen::Vector3d& up_ecef) {
  const Eigen::Vector3d east = east_of(up_ecef);
  const Eigen::Vector3d south = east.cross(up_ecef);
  direction_ = (0.8 * up_ecef + 0.25 * east + 0.5 * south).normalized().cast<float>();
}

Rgb sky_colour(double sine) {
  constexpr Rgb kHorizon{214, 222, 230}, kZenith{104, 144, 196};
  constexpr Rgb kGround{206, 209, 213}, kHaze{214, 220, 226};
  return sine >= 0 ? mix(kHorizon, kZenith, std::min(1.0, sine * 1.6))
                   : mix(kHaze, kGround, std::min(1.0, -sine * 6));
}

SkyColours::SkyColours() {
  for (std::size_t i = 0; i < table_.size(); ++i) {
    table_[i] = sky_colour(static_cast<double>(i) / kSteps - 1);
  }
}

}  // namespace voxatlas
