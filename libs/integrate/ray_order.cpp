#include "integrate/ray_order.hpp"

#include <array>

namespace voxatlas {
namespace {

constexpr int kBits = 5;  ///< Of each coordinate on a face.
constexpr std::uint32_t kSquares = 6u << 2 * kBits;

/// The low five bits, one bit apart.
constexpr std::array<std::uint16_t, 32> kSpread = [] {
  std::array<std::uint16_t, 32> spread{};
  for (unsigned i = 0; i < spread.size(); ++i) {
    for (unsigned bit = 0; bit < kBits; ++bit) {
      spread[i] = static_cast<std::uint16_t>(spread[i] | (i >> bit & 1) << 2 * bit);
    }
  }
  return spread;
}();

std::uint32_t square_of(const Eigen::Vector3d& way) {
  const Eigen::Vector3d size = way.cwiseAbs();
  int main = size[0] >= size[1] ? 0 : 1;
  if (size[2] > size[main]) main = 2;
  if (size[main] == 0) return 0;
  const auto on_face = [&](int axis) {  // From -1 to 1.
    const double at = way[axis] / size[main];
    return std::uint32_t{kSpread[static_cast<std::size_t>((at + 1) * 15.999)]};
  };
  const auto face = static_cast<std::uint32_t>(2 * main + (way[main] < 0));
  return face << 2 * kBits | on_face(main == 0 ? 1 : 0) << 1 | on_face(main == 2 ? 1 : 2);
}

}  // namespace

void RayOrder::sort(const Eigen::Vector3d& origin, std::vector<Eigen::Vector3d>& ends) {
  squares_.clear();
  next_.assign(kSquares + 1, 0);
  for (const auto& end : ends) {
    squares_.push_back(square_of(end - origin));
    ++next_[squares_.back() + 1];
  }
  for (std::size_t i = 1; i < next_.size(); ++i) next_[i] += next_[i - 1];
  sorted_.resize(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) sorted_[next_[squares_[i]]++] = ends[i];
  ends.swap(sorted_);
}

}  // namespace voxatlas
