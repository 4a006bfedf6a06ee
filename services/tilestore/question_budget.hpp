#pragma once

#include <algorithm>
#include <cstdint>

namespace voxatlas {

/// How much time a store gives to questions while scans come in: at most a share of it, so that no
/// number of observers holds the import back. Who gets no answer asks again.
///
/// Time:    microseconds of one steady clock, given with each call.
/// Threads: one at a time.
class QuestionBudget {
 public:
  static constexpr std::int64_t kShare = 2;           ///< One part in so many.
  static constexpr std::int64_t kMostUs = 50'000;     ///< Saved up.
  static constexpr std::int64_t kImportUs = 200'000;  ///< Since the last delta: it goes on.

  void delta_came(std::int64_t now) { last_delta_ = now; }
  /// Whether a question may be answered now.
  bool allows(std::int64_t now) {
    left_ = std::min(kMostUs, left_ + (now - counted_) / kShare);
    counted_ = now;
    return now - last_delta_ > kImportUs || left_ > 0;
  }
  /// An answer took so long.
  void spend(std::int64_t us) { left_ -= us; }

 private:
  std::int64_t last_delta_ = -kImportUs - 1;
  std::int64_t counted_ = 0;
  std::int64_t left_ = kMostUs;
};

}  // namespace voxatlas
