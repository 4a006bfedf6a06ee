#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace voxatlas {

/// Eight bits a channel: red, green, blue. What a scan sees and a picture shows.
struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(Rgb, Rgb) = default;
};

/// A voxel's colour: the running mean of what scans saw, 8.8 fixed point a channel, and their
/// number, 1..16; count 0 is "no colour", which is not white and not black.
///
/// Source: DESIGN section 3: n = min(n + 1, 16); mean += round((256 c - mean) / n).
/// The rounding is to nearest, halves away from zero, in integers.
struct Colour {
  std::array<std::uint16_t, 3> mean{};
  std::uint16_t count = 0;

  static constexpr std::uint16_t kMaxCount = 16;

  bool exists() const { return count != 0; }
  void add(Rgb seen);
  /// The mean, rounded to 8 bits a channel.
  Rgb rgb() const { return {rounded(mean[0]), rounded(mean[1]), rounded(mean[2])}; }

  friend bool operator==(const Colour&, const Colour&) = default;

 private:
  static std::uint8_t rounded(std::uint16_t mean) {
    return static_cast<std::uint8_t>(std::min((mean + 128) >> 8, 255));
  }
};

}  // namespace voxatlas
