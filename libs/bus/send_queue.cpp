#include "bus/send_queue.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"

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

void encode_chunk(const chunk_t& head, ByteView data, Bytes& bytes) {
  VOX_CHECK(head.data.empty() && static_cast<std::size_t>(head.size) == data.size());
  bytes.resize(static_cast<std::size_t>(head.getEncodedSize()));
  // The data and, before it, its size are the last fields.
  const auto front = bytes.size() - data.size();
  chunk_t without_data = head;
  without_data.size = 0;
  without_data.encode(bytes.data(), 0, static_cast<int>(front));
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[front - 4 + i] =
        static_cast<std::uint8_t>(static_cast<std::uint32_t>(head.size) >> (24 - 8 * i));
  }
  std::ranges::copy(data, bytes.begin() + static_cast<std::ptrdiff_t>(front));
}

}  // namespace voxatlas
