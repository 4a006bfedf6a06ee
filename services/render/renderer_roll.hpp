#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "bus/wire.hpp"

namespace voxatlas {

/// Which renderers live, and which of them answers a client: by rendezvous, so that all agree
/// without a word and only the clients of one that comes or goes change hands.
///
/// Source:  Thaler and Ravishankar, 1998: of all that live, the one whose hash with the client is
///          highest.
/// Life:    told by their statuses, twice a second; one that was not ready or not heard of for
///          kAlive does not count. Oneself always does.
/// Time:    is told, steady microseconds. Threads: one at a time.
class RendererRoll {
 public:
  static constexpr std::int64_t kAlive = 1'600'000;
  /// How long to listen before one says that one is ready: by then every other has spoken.
  static constexpr std::int64_t kListen = 600'000;

  /// `self`: status_t's instance.
  explicit RendererRoll(std::int64_t self) : self_(self) {}

  void on_status(const status_t& status, std::int64_t now);
  bool answers(std::int64_t client, std::int64_t now) const;
  std::size_t alive(std::int64_t now) const;

 private:
  std::int64_t self_;
  std::map<std::int64_t, std::int64_t> heard_;  // Others: instance, when.
};

}  // namespace voxatlas
