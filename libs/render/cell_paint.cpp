#include "render/cell_paint.hpp"

#include <cmath>

namespace voxatlas {
namespace {

constexpr float kNormalSteps = 63;  // From the middle of an octahedron's side to its rim.

/// The nearer half of the octahedron is a square; the other half is folded out around it.
Eigen::Vector2f fold(const Eigen::Vector2f& p) {
  const auto sign = [](float x) { return x < 0 ? -1.0f : 1.0f; };
  return {(1 - std::abs(p.y())) * sign(p.x()), (1 - std::abs(p.x())) * sign(p.y())};
}

}  // namespace

void CellPaint::set_normal(const Eigen::Vector3f& normal) {
  bits_ &= kColoured;
  if (normal.isZero()) return;
  const Eigen::Vector3f on_sides = normal / normal.cwiseAbs().sum();
  Eigen::Vector2f p = on_sides.head<2>();
  if (on_sides.z() < 0) p = fold(p);
  const auto steps = [](float x) {  // Never negative: cutting off is rounding, after a half.
    return static_cast<unsigned>((x + 1) * kNormalSteps + 0.5f) & 0x7fu;
  };
  bits_ = static_cast<std::uint16_t>(bits_ | kNormal | steps(p.x()) << 7 | steps(p.y()));
}

Eigen::Vector3f CellPaint::decode(std::uint16_t bits) {
  if ((bits & kNormal) == 0) return Eigen::Vector3f::Zero();
  Eigen::Vector2f p(static_cast<float>(bits >> 7 & 0x7f), static_cast<float>(bits & 0x7f));
  p = (p / kNormalSteps).array() - 1;
  const float z = 1 - p.cwiseAbs().sum();
  if (z < 0) p = fold(p);
  return Eigen::Vector3f(p.x(), p.y(), z).normalized();
}

const std::vector<Eigen::Vector3f>& CellPaint::normals() {
  static const std::vector<Eigen::Vector3f> all = [] {
    std::vector<Eigen::Vector3f> decoded;
    for (unsigned bits = 0; bits < 2u * kNormal; ++bits) {
      decoded.push_back(decode(static_cast<std::uint16_t>(bits)));
    }
    return decoded;
  }();
  return all;
}

}  // namespace voxatlas
