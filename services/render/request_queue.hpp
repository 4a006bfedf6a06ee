#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "bus/wire.hpp"

namespace voxatlas {

/// Requests that wait for a picture: the newest of each client, clients in turn.
///
/// A client that asks a thousand times a second replaces its own request and keeps its place; it
/// delays no other. Memory: kMaxClients requests; a further client's is refused.
class RequestQueue {
 public:
  static constexpr std::size_t kMaxClients = 64;

  enum class Offer { kWaits, kReplaced, kRefused };
  Offer offer(const render_request_t& request);

  /// The request of whoever has waited longest.
  std::optional<render_request_t> take();

  bool empty() const { return turns_.empty(); }
  std::size_t size() const { return turns_.size(); }

 private:
  std::deque<std::int64_t> turns_;  // Clients, each once.
  std::map<std::int64_t, render_request_t> waiting_;
};

}  // namespace voxatlas
