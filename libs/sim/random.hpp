#pragma once

#include <cstdint>
#include <initializer_list>

namespace voxatlas {

/// splitmix64's output function: equal inputs give equal numbers, on any machine.
inline std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
  x = (x ^ x >> 27) * 0x94d049bb133111eb;
  return x ^ x >> 31;
}

/// Random numbers that belong to a thing rather than to an order of making things: a draw is
/// named by integers (seed, block, house ...), and what others draw does not change it.
class Draw {
 public:
  Draw(std::initializer_list<std::uint64_t> name) {
    for (const auto part : name) state_ = mix(state_ ^ part);
  }

  std::uint64_t bits() { return state_ = mix(state_); }
  /// In [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  int below(int count) { return static_cast<int>(unit() * count); }
  bool chance(double probability) { return unit() < probability; }

 private:
  std::uint64_t state_ = 0;
};

}  // namespace voxatlas
