#pragma once

#include <cstdint>

#include "base/result.hpp"

namespace voxatlas {

/// A cell's log-odds in units of 1/4096: L = ln(P / (1 - P)). |L| < 8. Occupied where L >= 0.
using LogOdds = std::int16_t;

inline constexpr int kLogOddsPerUnit = 4096;

inline bool is_occupied(LogOdds log_odds) { return log_odds >= 0; }

double to_probability(LogOdds log_odds);
double to_float_log_odds(LogOdds log_odds);

/// The nearest lattice value. Errors: kOutOfRange for a probability outside (0, 1), NaN, or |L|
/// >= 8.
Result<LogOdds> to_log_odds(double probability);

/// What a hit and a miss add, and where the sum is clamped, after every single addition.
///
/// Source: the paper's section 4.1; defaults are OctoMap's: hit P = 0.7, miss 0.4, clamps 0.12,
/// 0.97.
struct SensorModel {
  LogOdds hit;
  LogOdds miss;
  LogOdds clamp_min;
  LogOdds clamp_max;

  /// All four from probabilities, rounded to the lattice. Errors: kOutOfRange where a probability
  /// is no log-odds, hit <= 0.5, miss >= 0.5, or not clamp_min < 0 <= clamp_max.
  static Result<SensorModel> from_probabilities(double hit, double miss, double clamp_min,
                                                double clamp_max);
  static SensorModel standard();

  /// hit > 0, miss < 0 and clamp_min < 0 <= clamp_max, as from_probabilities makes them.
  bool valid() const { return hit > 0 && miss < 0 && clamp_min < 0 && clamp_max >= 0; }

  /// One update: the clamped sum; an unknown voxel counts as 0 before it.
  LogOdds update(LogOdds before, LogOdds addend) const;

  friend bool operator==(const SensorModel&, const SensorModel&) = default;
};

}  // namespace voxatlas
