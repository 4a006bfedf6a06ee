#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "bus/message_kind.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// What a producer holds: messages whole, and for each of their chunks what has become of it. New
/// ones join at the end, committed ones leave at the front, and nothing is copied on the way.
class SendQueue {
 public:
  struct Chunk {
    chunk_t head;   ///< All fields but the data.
    ByteView data;  ///< Of its message.
    std::optional<std::uint32_t>
        data_crc{};  ///< Not before it is sent: then the data is read anyway.
    std::int64_t sent_at = 0;
    bool resent = false;
  };

  SendQueue(std::int64_t session, std::size_t chunk_bytes)
      : session_(session), chunk_bytes_(chunk_bytes) {}

  /// Returns the message's number: 0, 1, 2, ...
  std::int64_t push(MessageKind kind, Bytes payload);
  /// Frees the messages whose chunks are all below `committed`: the consumer commits whole
  /// messages. Returns whether there was one.
  bool free_below(std::int64_t committed);

  bool empty() const { return chunks_.empty(); }
  std::int64_t base() const { return offered_ - static_cast<std::int64_t>(chunks_.size()); }
  std::int64_t offered() const { return offered_; }  ///< Chunks so far.
  std::int64_t offered_messages() const { return offered_messages_; }
  std::int64_t committed_messages() const {
    return offered_messages_ - static_cast<std::int64_t>(messages_.size());
  }
  std::size_t held_bytes() const { return held_bytes_; }
  /// base() <= seq < offered().
  Chunk& at(std::int64_t seq) { return chunks_[static_cast<std::size_t>(seq - base())]; }
  std::vector<Bytes> payloads() const;  ///< Of what is held.

 private:
  struct Message {
    std::int64_t end;  ///< The chunk after its last.
    Bytes payload;
  };

  std::int64_t session_;
  std::size_t chunk_bytes_;
  std::deque<Chunk> chunks_;  ///< base() .. offered() - 1.
  std::deque<Message> messages_;
  std::size_t held_bytes_ = 0;
  std::int64_t offered_ = 0;
  std::int64_t offered_messages_ = 0;
};

}  // namespace voxatlas
