#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace voxatlas {

/// How much a commit takes at once, from what the last ones took: what is durable is told of when
/// its tile's turn has come, and nobody is to wait long for that, on a slow machine neither.
///
/// Only applying counts, not the sync before it: where that is slow, large commits are what helps.
class CommitPace {
 public:
  static constexpr std::int64_t kLongest = 100'000;  ///< Microseconds.
  static constexpr std::size_t kFewest = std::size_t{64} << 10;

  explicit CommitPace(std::size_t most_bytes) : most_(most_bytes) {}

  /// Bytes of deltas for the next commit; more where a single scan has more.
  std::size_t bytes() const {
    const double fit = bytes_ / took_ * static_cast<double>(kLongest);
    return static_cast<std::size_t>(
        std::clamp(fit, static_cast<double>(std::min(kFewest, most_)), static_cast<double>(most_)));
  }
  /// So many were applied in so many microseconds.
  void applied(std::size_t bytes, std::int64_t took) {
    constexpr double kKept = 0.75;  // Of what was before: some four commits count.
    bytes_ = kKept * bytes_ + static_cast<double>(bytes);
    took_ = std::max(1.0, kKept * took_ + static_cast<double>(took));
  }

 private:
  std::size_t most_;
  double bytes_ = 1 << 20, took_ = kLongest;  // A guess, until there were some.
};

}  // namespace voxatlas
