#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "render/question.hpp"

namespace voxatlas {

/// What there is to draw of a view, at one moment.
struct Sight {
  bool listed = false;      ///< It is known which tiles there are.
  bool complete = false;    ///< All of them are here, in full and new, or never will be.
  bool bare = false;        ///< Of some there is nothing to draw yet.
  std::uint64_t stamp = 0;  ///< Differs where anything to draw does.
  std::int32_t missing = 0;
  std::int64_t progress_at = 0;  ///< When fewer were missing than before, steady.
  std::uint64_t newest_version = 0;
  std::int64_t shown_until = 0;  ///< utime.
  std::shared_ptr<PictureTrees> trees;
};

/// The next picture of a view.
struct Shot {
  PaintJob job;
  double threshold = 0;
  int samples = 1;
  std::int32_t place = 0;
  std::int64_t due = 0;  ///< When it was wanted, steady.
  Sight sight;
};

/// What a client looks at: decides which picture is drawn of it next, and when; of a camera that
/// rests better ones, step by step; along a path one a place.
///
/// Exact:   a question without budget is answered by the whole picture, once all tiles are here.
///          With one, the first picture comes as soon as there is anything to draw, and again when
///          more has come; once all is here the pictures get better. One picture then stays with
///          what was here, or an import would never let it end; a stream begins again.
/// Late:    what everyone watches keeps its time and leaves places out; a client that takes
///          pictures by stream gets each one.
/// Patience: where no tile has come for kPatience, or the picture was due kMostPatience ago, those
///          that are missing are not waited for.
/// Time:    is told, steady microseconds; nothing is read.
class View {
 public:
  static constexpr std::int64_t kPatience = 3'000'000;
  static constexpr std::int64_t kMostPatience = 30'000'000;
  static constexpr std::int64_t kGrace = 100'000;  ///< A first picture waits so long for tiles.
  static constexpr std::int64_t kMoreGap =
      150'000;  ///< Between pictures that only show more tiles.

  /// `pacer`: the client's, which knows what its pictures took; must outlive the view.
  View(Question question, std::uint64_t ticket, Pacer& pacer, std::int64_t now);

  const Question& question() const { return question_; }
  std::uint64_t ticket() const { return ticket_; }
  const Camera& camera() const { return camera_; }
  std::int32_t place() const { return place_; }
  bool over() const { return over_; }
  /// Since when the present camera could be drawn, steady.
  std::int64_t since() const { return since_; }

  /// The picture to draw now, if any; painted() must follow before the next. `sight` is of
  /// camera().
  std::optional<Shot> next(const Sight& sight, std::int64_t now);
  /// When next() may have something though nothing has come in; INT64_MAX: never.
  std::int64_t next_time(std::int64_t now) const;

  /// What a frame says beside its picture.
  struct Mark {
    bool frame = true;  ///< False: a part of a supersampled picture; no frame yet.
    bool final = false, last = false;
    std::int64_t sequence = 0;
    std::int32_t over_budget = 0;
    bool late = false;  ///< It took longer than its budget.
  };
  Mark painted(PaintedPicture& picture, std::int64_t now);

  bool painting() const { return painting_; }

 private:
  std::int64_t gap() const { return question_.stream ? question_.gap_us : kMoreGap; }
  bool patient(const Sight& sight, std::int64_t now) const;
  bool ready(const Sight& sight, std::int64_t now) const;
  bool begins(const Sight& sight, std::int64_t now);
  bool refines(const Sight& sight, bool settled);
  Shot shot_of(const Sight& sight);
  void go_on(std::int64_t now);

  Question question_;
  std::uint64_t ticket_;
  Pacer& pacer_;
  Camera camera_;
  std::int64_t start_;  // When the first picture was due,
  std::int64_t due_;    // and the present one;
  std::int64_t since_;  // since when it could be drawn.
  std::int32_t place_;
  bool drawn_ = false;            // Something of the present camera,
  bool refined_ = false;          // and nothing better follows;
  bool settled_ = false;          // all tiles were here then, or given up,
  std::uint64_t stamp_ = 0;       // and this was to be seen.
  std::optional<PaceStep> step_;  // The last.
  double step_ms_ = 0;
  std::unique_ptr<Supersample> mean_;  // Under way.
  std::optional<Sight> held_;          // What is refined, whatever comes in.
  bool painting_ = false, over_ = false;
  std::int64_t begun_at_ = 0, sequence_ = 0;
  std::uint64_t over_budget_before_;
};

}  // namespace voxatlas
