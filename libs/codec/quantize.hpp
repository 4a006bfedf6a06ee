#pragma once

#include <cstdint>

#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// How coarse a lossy tile is.
struct Quantization {
  int bits = 6;               ///< Of a log-odds, 1..16: at most 2^bits values.
  int colour_bits = 5;        ///< Of a colour channel, 1..8; 0: colours are dropped.
  LogOdds clamp_min = -8161;  ///< The model's clamps, kept exactly; clamp_min < 0 <= clamp_max.
  LogOdds clamp_max = 14'238;

  /// Errors: kOutOfRange, naming the value that is not as above.
  Status check() const;
  friend bool operator==(const Quantization&, const Quantization&) = default;
};

/// How far a log-odds may move: never to the other side of 0, and at most by step() in probability.
/// A step is a side's width in probability, from 1/2 to the clamp, divided by 2^(bits-1) - 1 (by 1
/// for one bit); the clamps, and what lies outside them, do not move at all. Values farther than a
/// step apart are at most 2^(bits-1) on a side.
class LogOddsQuantizer {
 public:
  explicit LogOddsQuantizer(const Quantization& how);  ///< Must pass check().

  double step(bool occupied) const { return occupied ? occupied_step_ : free_step_; }
  /// At a clamp or outside.
  bool is_beyond(LogOdds log_odds) const {
    return log_odds <= clamp_min_ || log_odds >= clamp_max_;
  }
  /// May `from` become `to`: on the same side, within its step, and no clamp?
  bool within_step(LogOdds from, LogOdds to) const;

 private:
  LogOdds clamp_min_, clamp_max_;
  double free_step_, occupied_step_;
};

/// A colour whose channels have `bits` bits: the mean's nearest of 2^bits values spread over
/// 0..255, the count kept. Error: at most half of 255 / (2^bits - 1), rounded up (bits 1: 128).
Colour quantize(const Colour& colour, int bits);

/// Is every voxel unknown, free or occupied in both, or in neither? What quantize() promises.
bool same_occupancy(const TileTree& a, const TileTree& b);

/// The tile with few values, chosen among its own, each voxel within its step: a tile like any
/// other: updates go on from its values.
TileTree quantize(const TileTree& tree, const Quantization& how);

}  // namespace voxatlas
