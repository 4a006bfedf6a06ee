#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/bytes.hpp"
#include "bus/message_kind.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

struct StreamConfig {
  std::size_t chunk_bytes = 59'000;  ///< Data in a chunk; with its header below 60 000.
  std::size_t send_buffer_bytes = std::size_t{64}
                                  << 20;  ///< Held until committed; offer() refuses above.
  std::int64_t rto_us = 3'000;            ///< Silence before a probe asks what is missing; doubles
  std::int64_t rto_max_us = 500'000;      ///< while the silence lasts, up to this.
  std::int64_t client = 0;                ///< Where a client consumes: its id (client_session()).
};

/// A random session for a stream to a client. Clients may share a port (Endpoint), so the session
/// says whose it is: its upper 47 bits are the client's.
std::int64_t client_session(std::int64_t client);
/// Whether a session was made for this client.
bool is_session_of(std::int64_t session, std::int64_t client);

/// The sending end of a reliable stream: a state machine without clock, thread or socket.
///
/// Source:  DESIGN section 6 (credit, cumulative acknowledgement, ranged nacks, probes).
/// Time:    microseconds of one steady clock, given with each call.
/// Loss:    the consumer names what is missing, of itself or asked by a probe; only that goes out
///          again, and halves the window, which grows back with what arrives.
/// Credit:  unused, it lapses a tenth of a second after the last acknowledgement, as the consumer
///          gives it to others then; a probe asks for it again.
/// Promise: every message offered arrives at the consumer at least once, whole and in order, as
/// long as
///          both go on; a message is held until the consumer has committed it, so that a consumer
///          that lost its memory gets it again.
/// Memory:  send_buffer_bytes plus one message.
/// Threads: one at a time.
class StreamProducer {
 public:
  StreamProducer(std::int64_t session, const StreamConfig& config);
  ~StreamProducer();

  /// Whether offer() would take a message now.
  bool has_room() const;
  /// Queues a message and returns its number (0, 1, 2, ...); has_room() must hold. A message may be
  /// larger than the send buffer when the buffer is empty.
  std::int64_t offer(MessageKind kind, Bytes payload);

  void on_ack(const ack_t& ack, std::int64_t now);

  /// The chunks to send now, new, again, or a probe; at most `limit` at once.
  std::vector<chunk_t> poll(std::int64_t now, std::size_t limit = 16);
  /// Sees each chunk in turn, its data apart and not copied, and returns whether to go on.
  using Send = std::function<bool(const chunk_t& head, ByteView data)>;
  /// The same without copies; returns how many `send` saw.
  std::size_t poll(std::int64_t now, std::size_t limit, const Send& send);
  /// When poll() has something to do even if nothing comes in; INT64_MAX: never.
  std::int64_t next_poll(std::int64_t now) const;

  std::int64_t session() const;
  std::int64_t committed_messages() const;  ///< Every message below this number is committed.
  std::int64_t offered_messages() const;
  std::size_t held_bytes() const;
  std::int64_t credit() const;  ///< Chunks the consumer last said it would take.
  /// The payloads of all messages from committed_messages() on, for another stream to carry.
  std::vector<Bytes> uncommitted() const;
  /// When the consumer was last heard of; 0: never.
  std::int64_t last_heard() const;

  struct Counters {
    std::uint64_t chunks_sent = 0, chunks_resent = 0, probes = 0, acks = 0, consumer_restarts = 0;
    std::uint64_t acks_refused = 0;  ///< Damaged, or contradicting what was sent.
  };
  const Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
