#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <utility>

namespace voxatlas::test {

/// What a simulated wire does to the messages on it.
struct WireFaults {
  double loss = 0;       ///< Share of messages that vanish,
  double duplicate = 0;  ///< that arrive twice.
  std::int64_t delay_us = 50;
  std::int64_t jitter_us =
      0;  ///< Up to so much more, each by itself: messages overtake one another.
};

/// A wire without a network: what is sent at one time arrives at a later one, or not, by a seeded
/// engine. Simulated microseconds.
template <class Message>
class SimWire {
 public:
  SimWire(const WireFaults& faults, std::mt19937_64& rng) : faults_(faults), rng_(rng) {}

  void send(const Message& message, std::int64_t now) {
    ++sent_;
    if (chance(faults_.loss)) return;
    arrive(message, now);
    if (chance(faults_.duplicate)) arrive(message, now);
  }

  /// The next message that has arrived by now.
  std::optional<Message> receive(std::int64_t now) {
    if (under_way_.empty() || under_way_.begin()->first > now) return std::nullopt;
    return std::move(under_way_.extract(under_way_.begin()).mapped());
  }

  std::int64_t next_arrival() const {
    return under_way_.empty() ? INT64_MAX : under_way_.begin()->first;
  }
  std::size_t under_way() const { return under_way_.size(); }
  std::size_t sent() const { return sent_; }
  void set_faults(const WireFaults& faults) { faults_ = faults; }

 private:
  bool chance(double share) { return std::uniform_real_distribution<double>()(rng_) < share; }

  void arrive(const Message& message, std::int64_t now) {
    const auto more =
        faults_.jitter_us == 0 ? 0 : static_cast<std::int64_t>(rng_() % faults_.jitter_us);
    under_way_.emplace(now + faults_.delay_us + more, message);
  }

  WireFaults faults_;
  std::mt19937_64& rng_;
  std::multimap<std::int64_t, Message> under_way_;  ///< By arrival; those of one time in order.
  std::size_t sent_ = 0;
};

}  // namespace voxatlas::test
