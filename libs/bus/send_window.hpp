#pragma once

#include <algorithm>
#include <cstdint>

namespace voxatlas {

/// How many chunks a producer keeps under way, within its credit: halved by loss, grown by arrival.
class SendWindow {
 public:
  std::int64_t chunks() const { return static_cast<std::int64_t>(size_); }

  /// Doubles each round until the first loss, then grows by one a round.
  void arrived(std::int64_t count) {
    const double grown = lossless_ ? 1.0 : 1.0 / size_;
    size_ = std::min(kMost, size_ + grown * static_cast<double>(count));
  }

  /// A chunk was lost: halves once for all losses of one round.
  void lost(std::int64_t now) {
    if (!lossless_ && now - last_loss_ < kRoundUs) return;
    lossless_ = false;
    last_loss_ = now;
    size_ = std::max(kLeast, size_ / 2);
  }

 private:
  static constexpr double kStart = 32;
  /// The credit already keeps the receiver from drowning, so this is for the network's sake, as
  /// TCP begins with ten packets. Fewer, and losses show late: by what comes after them.
  static constexpr double kLeast = 8;
  static constexpr double kMost = 4096;
  static constexpr std::int64_t kRoundUs = 5'000;

  double size_ = kStart;
  bool lossless_ = true;
  std::int64_t last_loss_ = 0;
};

}  // namespace voxatlas
