#include "render/ramp.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace voxatlas {
namespace {

std::uint8_t between(std::uint8_t a, std::uint8_t b, double t) {
  return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
}

/// Zero for NaN, too.
double hold(double t) { return t > 0 ? std::min(t, 1.0) : 0.0; }

template <std::size_t N>
Rgb along(const std::array<Rgb, N>& colours, double t) {
  const double at = hold(t) * (N - 1);
  const auto i = std::min(static_cast<std::size_t>(at), N - 2);
  const double rest = at - static_cast<double>(i);
  const Rgb a = colours[i];
  const Rgb b = colours[i + 1];
  return {between(a.r, b.r, rest), between(a.g, b.g, rest), between(a.b, b.b, rest)};
}

}  // namespace

Rgb ramp_colour(double t) {
  static constexpr std::array<Rgb, 9> kColours = {{{70, 50, 126},
                                                   {63, 80, 150},
                                                   {51, 110, 155},
                                                   {42, 139, 152},
                                                   {52, 167, 138},
                                                   {101, 191, 114},
                                                   {160, 210, 80},
                                                   {215, 224, 70},
                                                   {250, 236, 120}}};
  return along(kColours, t);
}

Rgb height_colour(double part_of_height) { return ramp_colour(std::sqrt(hold(part_of_height))); }

Rgb neutral_colour(double part_of_height) {
  static constexpr std::array<Rgb, 5> kColours = {
      {{112, 119, 132}, {150, 142, 132}, {198, 160, 118}, {214, 198, 164}, {240, 232, 212}}};
  return along(kColours, std::sqrt(hold(part_of_height)));
}

Rgb ellipsoid_colour(double height) {
  const double turns = height / (2 * kEllipsoidTurn);
  return ramp_colour(1 - std::abs(2 * (turns - std::floor(turns)) - 1));
}

Rgb depth_colour(int depth) {
  static constexpr std::array<Rgb, 8> kColours = {{{136, 34, 85},
                                                   {170, 68, 153},
                                                   {204, 102, 119},
                                                   {221, 204, 119},
                                                   {153, 153, 51},
                                                   {17, 119, 51},
                                                   {68, 170, 153},
                                                   {136, 204, 238}}};
  return kColours[static_cast<std::size_t>(std::clamp(depth, 0, 7))];
}

HeightColours::HeightColours(Rgb (*colour)(double), double rise) : steps_per_metre_(kSteps / rise) {
  for (std::size_t i = 0; i < table_.size(); ++i) {
    table_[i] = colour(static_cast<double>(i) / kSteps);
  }
}

}  // namespace voxatlas
