#include "octree/log_odds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.hpp"

namespace voxatlas {

double to_float_log_odds(LogOdds log_odds) {
  return static_cast<double>(log_odds) / kLogOddsPerUnit;
}

double to_probability(LogOdds log_odds) { return 1 / (1 + std::exp(-to_float_log_odds(log_odds))); }

Result<LogOdds> to_log_odds(double probability) {
  if (!(probability > 0 && probability < 1)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("probability {} is not between 0 and 1", probability));
  }
  const double steps = std::round(std::log(probability / (1 - probability)) * kLogOddsPerUnit);
  if (!(std::abs(steps) <= std::numeric_limits<LogOdds>::max())) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("probability {} has log-odds {:.4f}, not below 8 in magnitude",
                            probability, steps / kLogOddsPerUnit));
  }
  return static_cast<LogOdds>(steps);
}

namespace {

Result<LogOdds> named_log_odds(const char* name, double probability) {
  auto log_odds = to_log_odds(probability);
  if (!log_odds) return pass_on(log_odds, name);
  return log_odds;
}

}  // namespace

Result<SensorModel> SensorModel::from_probabilities(double hit, double miss, double clamp_min,
                                                    double clamp_max) {
  auto l_hit = named_log_odds("hit", hit);
  if (!l_hit) return pass_on(l_hit);
  auto l_miss = named_log_odds("miss", miss);
  if (!l_miss) return pass_on(l_miss);
  auto l_min = named_log_odds("clamp_min", clamp_min);
  if (!l_min) return pass_on(l_min);
  auto l_max = named_log_odds("clamp_max", clamp_max);
  if (!l_max) return pass_on(l_max);
  const SensorModel model{*l_hit, *l_miss, *l_min, *l_max};
  if (!model.valid()) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("hit {} must be above 0.5, miss {} below it, and clamp_min {} below "
                            "0.5, which clamp_max {} is not, each by a step of 1/4096",
                            hit, miss, clamp_min, clamp_max));
  }
  return model;
}

SensorModel SensorModel::standard() {
  const auto model = from_probabilities(0.7, 0.4, 0.12, 0.97);
  VOX_CHECK(model.has_value());
  return *model;
}

LogOdds SensorModel::update(LogOdds before, LogOdds addend) const {
  const int sum = int{before} + int{addend};
  return static_cast<LogOdds>(std::clamp(sum, int{clamp_min}, int{clamp_max}));
}

}  // namespace voxatlas
