#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/bytes.hpp"
#include "bus/message_kind.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

struct ConsumerConfig {
  std::size_t receive_buffer_bytes =
      208 * 1024;  ///< The socket's: credit in flight stays below it.
  std::size_t max_message_bytes = std::size_t{64} << 20;
  std::size_t max_held_bytes = std::size_t{256} << 20;  ///< Of messages not yet taken or in pieces.
  std::int64_t producer_timeout_us =
      10'000'000;           ///< A silent producer's turn and memory are freed.
  std::int64_t client = 0;  ///< Not 0: only streams to this client are taken (client_session()).
};

/// A message that has arrived whole.
struct StreamMessage {
  std::int64_t session = 0;  ///< Of the stream it came by.
  std::int64_t number = 0;   ///< Of the message in it.
  MessageKind kind{};
  Bytes payload;
};

/// The receiving end of any number of reliable streams: a state machine without clock, thread or
/// socket.
///
/// Source:  DESIGN section 6.
/// Time:    microseconds of one steady clock, given with each call.
/// Promise: each stream's messages come once each, whole, in order; again only after a restart of
///          the consumer and only those whose producer did not know them committed yet.
/// Credit:  the receive buffer divided among the producers that have something to send, granted in
///          turns, at least one chunk to whoever holds the turn; withheld while max_held_bytes are
///          held. What a silent producer leaves unused lapses and goes to others.
/// Hostile: a chunk whose CRC or size contradicts is dropped and counted; a stream whose chunks
///          contradict one another is not listened to any more. At most 1024 streams at once.
/// Memory:  max_held_bytes, one message of max_message_bytes and a receive buffer.
/// Threads: one at a time.
class StreamConsumer {
 public:
  StreamConsumer(std::int64_t incarnation, const ConsumerConfig& config);
  ~StreamConsumer();

  void on_chunk(const chunk_t& chunk, std::int64_t now);
  /// A chunk whose data lie elsewhere: copied once, into the message they are a piece of.
  void on_chunk(const chunk_t& head, ByteView data, std::int64_t now);

  /// Messages complete and in order, as they came; they stay uncommitted.
  std::vector<StreamMessage> take();
  /// Message `number` of a stream, and every earlier one, is done with.
  void commit(std::int64_t session, std::int64_t number);

  /// The acknowledgements to send now.
  std::vector<ack_t> poll(std::int64_t now);
  /// When poll() has something to do even if nothing comes in; INT64_MAX: never.
  std::int64_t next_poll(std::int64_t now) const;

  std::size_t held_bytes() const;
  std::int64_t credit() const;  ///< Chunks granted to all producers and not yet there.

  struct Counters {
    std::uint64_t chunks = 0, duplicates = 0, refused = 0, acks_sent = 0, gaps_reported = 0;
    std::uint64_t messages = 0, active_producers = 0;
  };
  const Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
