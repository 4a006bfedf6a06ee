#include "render/pacer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxatlas {
namespace {

constexpr double kHour = 3.6e6;

/// `guess`: what it costs by the full picture, before anything was measured.
struct Rung {
  int depths_up;
  double pixel_threshold;
  int shrink;
  int samples;
  double guess;
};
constexpr std::array<Rung, Pacer::kRungs> kLadder = {{{3, 8, 4, 1, 0.08},
                                                      {2, 4, 4, 1, 0.10},
                                                      {1, 4, 2, 1, 0.25},
                                                      {0, 2, 2, 1, 0.35},
                                                      {0, 4, 1, 1, 0.70},
                                                      {0, 1.5, 1, 1, 0.90},
                                                      {0, 0, 1, 1, 1},
                                                      {0, 0, 1, 4, 16}}};
/// Milliseconds of a full picture by the megapixel, before anything was measured: rather too many,
/// so that the first picture is small, not late.
constexpr double kFirstGuess = 60;

/// The scene changes with each view, a rung's share of it slowly.
constexpr double kSceneGain = 0.5, kOwnGain = 0.2;

/// A prediction is a mean, and half of all pictures take longer than the mean.
constexpr double kReserve = 1.25;

/// A step that is not at least this much dearer than the last shows little that is new.
constexpr double kWorthAStep = 2;

}  // namespace

Status Pacer::begin(const Pace& pace) {
  if (!(pace.budget_ms >= 0 && pace.budget_ms <= kHour)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("pacer: a budget of {} ms is not within 0..{}", pace.budget_ms, kHour));
  }
  if (pace.depth < 0 || pace.depth > kDepth) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("pacer: depth {} is not within 0..{}", pace.depth, kDepth));
  }
  if (pace.pixels < 1) {
    return fail(ErrorCode::kOutOfRange, fmt::format("pacer: a picture of {} pixels", pace.pixels));
  }
  pace_ = pace;
  drawn_.reset();
  done_ = false;
  return {};
}

std::optional<PaceStep> Pacer::next() {
  if (done_) return std::nullopt;
  return step_of(drawn_ ? better_rung() : first_rung());
}

/// The best that is believed to come in time; where none is, the least.
std::size_t Pacer::first_rung() const {
  if (!(pace_->budget_ms > 0)) return kFull;
  std::size_t rung = kFull;
  while (rung > 0 && predicted_ms(rung, pace_->pixels) * kReserve > pace_->budget_ms) --rung;
  return rung;
}

std::size_t Pacer::better_rung() const {
  std::size_t rung = *drawn_ + 1;
  const double last = predicted_ms(*drawn_, pace_->pixels);
  while (rung < kFull && predicted_ms(rung, pace_->pixels) < kWorthAStep * last) ++rung;
  return rung;
}

PaceStep Pacer::step_of(std::size_t rung) {
  const Rung& how = kLadder[rung];
  PaceStep step;
  step.sequence = ++sequence_;
  step.depth = std::max(0, pace_->depth - how.depths_up);
  step.pixel_threshold = how.pixel_threshold;
  step.shrink = how.shrink;
  step.samples = how.samples;
  step.budget_ms = pace_->budget_ms;
  step.in_budget = !drawn_ && pace_->budget_ms > 0;
  step.predicted_ms = predicted_ms(rung, pace_->pixels);
  step.rung = rung;
  step.final = done_ = rung == (pace_->supersample ? kRungs - 1 : kFull);
  drawn_ = rung;
  return step;
}

void Pacer::measured(const PaceStep& step, double ms) {
  const double took = ms >= 0 ? std::min(ms, kHour) : 0;  // NaN too.
  if (step.in_budget) {
    ++budgeted_;
    over_budget_ += took > step.budget_ms;
  }
  constexpr double kLeast = 0.01;  // Milliseconds: logarithms need some.
  const double off = std::log(std::max(took, kLeast) / std::max(step.predicted_ms, kLeast));
  scene_ += (known_ ? kSceneGain : 1) * off;
  if (known_) own_[step.rung] += kOwnGain * off;
  known_ = true;
}

double Pacer::predicted_ms(std::size_t rung, std::int64_t pixels) const {
  const double megapixels = static_cast<double>(pixels) / 1e6;
  return kFirstGuess * megapixels * kLadder[rung].guess * std::exp(scene_ + own_[rung]);
}

}  // namespace voxatlas
