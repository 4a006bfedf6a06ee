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

/// Log-odds in few values. 2^(bits-1) of them are free and as many occupied, so that no value ever
/// changes side. On each side they lie evenly *in probability*, as the paper's do, between 1/2 and
/// the clamp, which is one of them; with one bit the clamps are the only two.
///
/// Error: the probability moves by at most step(); the clamps, and what lies outside them, do not
///        move at all.
class LogOddsQuantizer {
 public:
  explicit LogOddsQuantizer(const Quantization& how);  ///< Must pass check().

  LogOdds nearest(LogOdds log_odds) const;
  /// The distance of neighbouring values in probability, and half of the lattice's own.
  double step(bool occupied) const { return side(occupied).step; }
  /// May `from` become `to`: on the same side, within its step, and no clamp?
  bool within_step(LogOdds from, LogOdds to) const;

 private:
  struct Side {
    double even, clamp;  ///< Probabilities.
    int levels;
    double step;
  };
  const Side& side(bool occupied) const { return occupied ? occupied_ : free_; }
  bool is_beyond(LogOdds log_odds) const {
    return log_odds <= clamp_min_ || log_odds >= clamp_max_;
  }

  LogOdds clamp_min_, clamp_max_;
  Side free_, occupied_;
};

/// A colour whose channels have `bits` bits: the mean's nearest of 2^bits values spread over
/// 0..255, the count kept. Error: at most half of 255 / (2^bits - 1), rounded up (bits 1: 128).
Colour quantize(const Colour& colour, int bits);

/// The tile of the quantised voxels, a tile like any other: updates go on from its values.
TileTree quantize(const TileTree& tree, const Quantization& how);

}  // namespace voxatlas
