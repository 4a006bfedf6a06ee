#include "render/request_queue.hpp"

#include <utility>

namespace voxatlas {

RequestQueue::Offer RequestQueue::offer(const render_request_t& request) {
  if (const auto mine = waiting_.find(request.client); mine != waiting_.end()) {
    mine->second = request;
    return Offer::kReplaced;
  }
  if (waiting_.size() >= kMaxClients) return Offer::kRefused;
  waiting_.emplace(request.client, request);
  turns_.push_back(request.client);
  return Offer::kWaits;
}

std::optional<render_request_t> RequestQueue::take() {
  if (turns_.empty()) return std::nullopt;
  const auto mine = waiting_.find(turns_.front());
  turns_.pop_front();
  std::optional<render_request_t> request = std::move(mine->second);
  waiting_.erase(mine);
  return request;
}

}  // namespace voxatlas
