#include "render/view.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"

namespace voxatlas {

View::View(Question question, std::uint64_t ticket, Pacer& pacer, std::int64_t now)
    : question_(std::move(question)),
      ticket_(ticket),
      pacer_(pacer),
      camera_(question_.camera),
      start_(now),
      due_(now),
      since_(now),
      place_(question_.first),
      over_budget_before_(pacer.over_budget()) {}

/// Whether tiles that are missing are still waited for.
bool View::patient(const Sight& sight, std::int64_t now) const {
  return now < std::max(since_, sight.progress_at) + kPatience && now < since_ + kMostPatience;
}

/// Whether the first picture of the present camera can be drawn.
bool View::ready(const Sight& sight, std::int64_t now) const {
  if (!patient(sight, now)) return true;
  if (!sight.listed) return false;
  if (question_.exact()) return sight.complete;
  return !sight.bare || question_.path || now >= since_ + kGrace;
}

/// Whether what is to be seen is drawn from the beginning: for the first time, or because it is
/// not what was drawn.
bool View::begins(const Sight& sight, std::int64_t now) {
  if (!drawn_) return ready(sight, now);
  if (question_.path || sight.stamp == stamp_) return false;
  const bool all_here_now = sight.complete && !settled_;
  return all_here_now || now >= begun_at_ + gap();
}

/// Takes the next better step; false where there is none, or the time for it has not come.
bool View::refines(const Sight& sight, bool settled) {
  if (!drawn_ || question_.path || !settled || sight.stamp != stamp_) return false;
  if (mean_ != nullptr) return true;
  if (refined_ && settled_) return false;
  const auto better =
      refined_ ? step_ : pacer_.next();  // Once more, to say that nothing is missing.
  if (!better) return false;
  step_ = better;
  step_ms_ = 0;
  held_ = sight;
  if (step_->samples > 1) mean_ = std::make_unique<Supersample>(camera_, step_->samples);
  return true;
}

std::optional<Shot> View::next(const Sight& seen, std::int64_t now) {
  if (painting_ || over_ || now < due_) return std::nullopt;
  const Sight sight = held_ && !question_.stream ? *held_ : seen;
  const bool settled = sight.complete || !patient(sight, now);
  if (begins(sight, now)) {
    const Status begun = pacer_.begin(question_.pace);
    VOX_CHECK(begun.has_value());  // Checked with the question.
    mean_.reset();
    step_ = pacer_.next();
    step_ms_ = 0;
    begun_at_ = now;
    held_.reset();
    if (settled) held_ = sight;
  } else if (!refines(sight, settled)) {
    return std::nullopt;
  }
  painting_ = true;
  settled_ = settled;
  stamp_ = sight.stamp;
  return shot_of(mean_ ? *held_ : sight);
}

Shot View::shot_of(const Sight& sight) {
  Shot shot{{ticket_, step_->shrink > 1 ? camera_.shrunk(step_->shrink) : camera_, sight.trees,
             question_.how, question_.encode, std::move(mean_)},
            step_->pixel_threshold,
            step_->samples,
            place_,
            since_,
            sight};
  shot.job.how.splat.max_depth = step_->depth;
  shot.job.how.splat.pixel_threshold = step_->pixel_threshold;
  return shot;
}

View::Mark View::painted(PaintedPicture& picture, std::int64_t now) {
  Mark mark;
  painting_ = false;
  drawn_ = true;
  step_ms_ += picture.all_ms;
  if (picture.mean && picture.sound && !picture.mean->complete()) {
    mean_ = std::move(picture.mean);
    mark.frame = false;
    return mark;
  }
  if (picture.sound) pacer_.measured(*step_, step_ms_);
  refined_ = step_->final;
  mark.final = refined_ && settled_;
  mark.sequence = sequence_++;
  mark.late = step_->in_budget && step_ms_ > step_->budget_ms;
  mark.over_budget = static_cast<std::int32_t>(pacer_.over_budget() - over_budget_before_);
  if (question_.path) go_on(now);
  if (!question_.stream) over_ = mark.final;
  if (!picture.sound) over_ = true;  // The next would be no better.
  mark.last = over_;
  if (!picture.sound) mark.final = true;
  return mark;
}

/// To the path's next place: each in turn, or the one that time has come to.
void View::go_on(std::int64_t now) {
  const std::int32_t last = question_.path->places(question_.rate) - 1;
  if (place_ == last) {
    over_ = true;
    return;
  }
  ++place_;
  if (question_.reply_port == 0) {
    const auto reached = question_.first + (now - start_) / question_.gap_us;
    place_ = static_cast<std::int32_t>(
        std::min<std::int64_t>(last, std::max<std::int64_t>(place_, reached)));
  }
  camera_ = question_.path->at(place_ / question_.rate);
  due_ = start_ + (place_ - question_.first) * question_.gap_us;
  since_ = std::max(due_, now);
  drawn_ = refined_ = settled_ = false;
  held_.reset();
}

std::int64_t View::next_time(std::int64_t now) const {
  if (painting_ || over_) return INT64_MAX;
  std::int64_t next = INT64_MAX;
  const auto may_be = [&](std::int64_t time) {
    if (time > now) next = std::min(next, time);
  };
  may_be(due_);
  may_be(since_ + kGrace);
  may_be(now + kPatience);  // Or a little later, where tiles were still coming.
  if (drawn_) may_be(begun_at_ + gap());
  return next;
}

}  // namespace voxatlas
