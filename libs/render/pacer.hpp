#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/result.hpp"
#include "grid/cell_key.hpp"

namespace voxatlas {

/// What a viewer wants of the pictures of one view.
struct Pace {
  double budget_ms = 0;     ///< For the first picture; 0: the full one, whatever it takes.
  int depth = kDepth;       ///< No cell deeper than this, 0..7.
  std::int64_t pixels = 1;  ///< Of the full picture.
  bool supersample = true;  ///< End with 4 x 4 rays a pixel.
};

/// One picture to draw.
struct PaceStep {
  std::int64_t sequence = 0;   ///< Counts the steps of a Pacer, from 1.
  int depth = kDepth;          ///< SplatOptions::max_depth.
  double pixel_threshold = 0;  ///< SplatOptions::pixel_threshold.
  int shrink = 1;              ///< The picture's sides are divided by it (Camera::shrunk).
  int samples = 1;             ///< Rays a pixel, on each side: 1 or 4 (Supersampler).
  bool final = false;          ///< No better picture of this view follows.
  bool in_budget = false;      ///< The budget is meant for it: the first of a view that has one.
  double budget_ms = 0;        ///< The view's.
  double predicted_ms = 0;     ///< What it is believed to take.
  std::size_t rung = 0;        ///< Pacer's own.
};

/// Decides what to draw so that the first picture of a view comes within its budget, and better
/// ones follow while the camera rests, up to the full picture and then the supersampled one.
///
/// Source:  DESIGN section 9. Not the paper's factor of 8 a depth: each rung of a ladder, from a
///          quarter of the sides three depths up to the full picture, keeps a moving average of
///          what it took, and all share one of what the scene costs at present; so one measurement
///          says something of every rung, and those never tried are judged by the others.
/// Full:    the rung before supersampling is depth, threshold 0, every pixel: the same options as a
///          picture without budget, so the same bits.
/// Refining: each step takes believed twice to four times what the one before took, so that few are
///          drawn in vain; rungs that would bring nothing new are passed over.
/// Time:    is told, never read: the same calls give the same steps.
/// Threads: one at a time.
class Pacer {
 public:
  /// Forgets the view before and begins another; what was measured stays.
  /// Errors: kOutOfRange, naming the value, for a budget that is negative, not finite or above an
  ///         hour, a depth outside 0..7, and pixels below 1; the view before then goes on.
  Status begin(const Pace& pace);

  /// The next picture of the view; nullopt after the final one, and before begin().
  std::optional<PaceStep> next();

  /// What a step took. Steps may be abandoned: they need not be measured. Times that are not
  /// finite or negative are held to 0 .. an hour.
  void measured(const PaceStep& step, double ms);

  double predicted_ms(std::size_t rung, std::int64_t pixels) const;
  /// Pictures that had a budget, and those of them that took longer.
  std::uint64_t budgeted() const { return budgeted_; }
  std::uint64_t over_budget() const { return over_budget_; }

  static constexpr std::size_t kRungs = 8;          ///< The last is the supersampled picture,
  static constexpr std::size_t kFull = kRungs - 2;  ///< the one before it the full one.

 private:
  std::size_t first_rung() const;
  std::size_t better_rung() const;
  PaceStep step_of(std::size_t rung);

  std::optional<Pace> pace_;
  std::optional<std::size_t> drawn_;  // The rung of the view's last step.
  bool done_ = true;
  std::int64_t sequence_ = 0;
  double scene_ = 0;  // Logarithm of the scene's cost over the ladder's first guess,
  bool known_ = false;
  std::array<double, kRungs> own_{};  // and what each rung adds to it.
  std::uint64_t budgeted_ = 0, over_budget_ = 0;
};

}  // namespace voxatlas
