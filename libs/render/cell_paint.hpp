#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octree/tile_tree.hpp"

namespace voxatlas {

/// What a picture needs to know of a cell to colour it.
///
/// Layout: the log-odds, which are not negative, in steps of 1/32; a colour; a normal as its place
///         on an octahedron, 7 bits a side, right to two degrees, either way round; two flags.
class CellPaint {
 public:
  CellPaint() = default;
  /// Without a normal.
  explicit CellPaint(const CellState& state)
      : log_odds_(static_cast<std::uint8_t>(state.log_odds >> kLogOddsShift)) {
    if (!state.colour.exists()) return;
    rgb_ = state.colour.rgb();
    bits_ = kColoured;
  }

  /// Of length 1, or zero for none.
  void set_normal(const Eigen::Vector3f& normal);
  void set_normal_of(const CellPaint& other) {
    bits_ = static_cast<std::uint16_t>((bits_ & kColoured) | (other.bits_ & ~kColoured));
  }

  LogOdds log_odds() const { return static_cast<LogOdds>(log_odds_ << kLogOddsShift); }
  bool coloured() const { return (bits_ & kColoured) != 0; }
  Rgb rgb() const { return rgb_; }  ///< Says something only where coloured().
  /// Of about length 1; zero where there is none.
  Eigen::Vector3f normal() const { return decode(bits_); }
  /// The same as a look into normals(), for whoever needs many.
  std::size_t normal_index() const { return bits_ & (2u * kNormal - 1); }
  static const std::vector<Eigen::Vector3f>& normals();

  static constexpr int kLogOddsShift = 7;

 private:
  static constexpr std::uint16_t kColoured = 1u << 15, kNormal = 1u << 14;

  static Eigen::Vector3f decode(std::uint16_t bits);

  std::uint8_t log_odds_ = 0;
  Rgb rgb_;
  std::uint16_t bits_ = 0;
};
static_assert(sizeof(CellPaint) == 6);

}  // namespace voxatlas
