#pragma once

#include <compare>
#include <cstdint>
#include <deque>
#include <map>

#include "base/bytes.hpp"

namespace voxatlas {

/// A server's last answers: a question that is asked again, because it or its answer was lost or
/// late, gets the same answer without the work.
///
/// Key:     the question's type (its fingerprint), client and id. A client does not use an id twice
///          for different questions of a type.
/// Time:    microseconds of one steady clock, given with each call.
/// Memory:  max_bytes of answers, none older than max_age_us; the oldest go first.
/// Threads: one at a time.
class ReplyCache {
 public:
  ReplyCache(std::size_t max_bytes, std::int64_t max_age_us)
      : max_bytes_(max_bytes), max_age_us_(max_age_us) {}

  struct Question {
    std::int64_t type = 0, client = 0, id = 0;
    friend auto operator<=>(const Question&, const Question&) = default;
  };
  /// The answer given before, encoded; nullptr: there is none. Valid until keep().
  const Bytes* find(const Question& question, std::int64_t now) const;
  /// An answer above max_bytes is not kept.
  void keep(const Question& question, Bytes answer, std::int64_t now);

 private:
  void forget(std::int64_t now);

  struct Answer {
    Bytes bytes;
    std::int64_t given = 0;
  };
  std::size_t max_bytes_;
  std::int64_t max_age_us_;
  std::map<Question, Answer> answers_;
  std::deque<Question> order_;  ///< Oldest first; each stands in answers_.
  std::size_t bytes_ = 0;
};

}  // namespace voxatlas
