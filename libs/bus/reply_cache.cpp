#include "bus/reply_cache.hpp"

#include <utility>

namespace voxatlas {

const Bytes* ReplyCache::find(const Question& question, std::int64_t now) const {
  const auto known = answers_.find(question);
  if (known == answers_.end() || now - known->second.given > max_age_us_) return nullptr;
  return &known->second.bytes;
}

void ReplyCache::keep(const Question& question, Bytes answer, std::int64_t now) {
  forget(now);
  if (answer.size() > max_bytes_ || answers_.contains(question)) return;
  bytes_ += answer.size();
  answers_.emplace(question, Answer{std::move(answer), now});
  order_.push_back(question);
  forget(now);
}

void ReplyCache::forget(std::int64_t now) {
  while (!order_.empty()) {
    const auto oldest = answers_.find(order_.front());
    if (bytes_ <= max_bytes_ && now - oldest->second.given <= max_age_us_) return;
    bytes_ -= oldest->second.bytes.size();
    answers_.erase(oldest);
    order_.pop_front();
  }
}

}  // namespace voxatlas
