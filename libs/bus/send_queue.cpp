#include "bus/send_queue.hpp"

#include <algorithm>
#include <utility>

namespace voxatlas {

std::int64_t SendQueue::push(MessageKind kind, Bytes payload) {
  const auto& message = messages_.emplace_back(Message{0, std::move(payload)});
  const ByteView all = message.payload;
  const auto count = std::max<std::size_t>(1, (all.size() + chunk_bytes_ - 1) / chunk_bytes_);
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = i * chunk_bytes_;
    Chunk chunk{{}, all.subspan(first, std::min(chunk_bytes_, all.size() - first))};
    chunk.head.session = session_;
    chunk.head.seq = offered_++;
    chunk.head.message = offered_messages_;
    chunk.head.index = static_cast<std::int32_t>(i);
    chunk.head.count = static_cast<std::int32_t>(count);
    chunk.head.kind = static_cast<std::int16_t>(kind);
    chunk.head.size = static_cast<std::int32_t>(chunk.data.size());
    chunks_.push_back(std::move(chunk));
  }
  messages_.back().end = offered_;
  held_bytes_ += all.size();
  return offered_messages_++;
}

bool SendQueue::free_below(std::int64_t committed) {
  bool freed = false;
  while (!messages_.empty() && messages_.front().end <= committed) {
    const auto end = messages_.front().end;
    chunks_.erase(chunks_.begin(), chunks_.begin() + (end - base()));
    held_bytes_ -= messages_.front().payload.size();
    messages_.pop_front();
    freed = true;
  }
  return freed;
}

std::vector<Bytes> SendQueue::payloads() const {
  std::vector<Bytes> payloads;
  for (const auto& message : messages_) payloads.push_back(message.payload);
  return payloads;
}

}  // namespace voxatlas
