#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "bus/stream_consumer.hpp"
#include "bus/stream_producer.hpp"
#include "support/sim_wire.hpp"

namespace voxatlas::test {

/// Producers and one consumer on simulated wires, and the oracle: the list of what each offered.
///
/// The consumer's receive buffer is real: chunks that arrive while it is full are lost, as the
/// kernel loses them. The consumer reads it `read_every_us` apart.
class StreamWorld {
 public:
  struct Setup {
    int producers = 1;
    int messages = 30;  ///< Of each producer.
    std::size_t least_bytes = 0;
    std::size_t most_bytes = 400'000;  ///< Of a message; sizes are random.
    WireFaults chunks;
    WireFaults acks;
    double damage = 0;                 ///< Share of chunks and acknowledgements with a wrong bit.
    std::int64_t read_every_us = 0;    ///< 0: at once.
    std::int64_t take_every_us = 0;    ///< 0: the consumer takes messages when they are there.
    std::int64_t commit_after_us = 0;  ///< How long the consumer works on a message.
    std::size_t buffer_bytes = 208 * 1024;
    StreamConfig stream;
    ConsumerConfig consumer;
  };

  StreamWorld(const Setup& setup, std::mt19937_64& rng);

  /// Runs until all messages are committed, or simulated time is over. True: all committed.
  bool run(std::int64_t most_us);
  bool step();
  /// The consumer dies and comes back without what it had not committed.
  void restart_consumer();
  /// A producer dies and comes back as a new stream with what was not committed.
  void restart_producer(std::size_t index);

  bool done() const;

  struct Oracle {
    std::vector<Bytes> offered;         ///< By number.
    std::set<std::int64_t> committed;   ///< As the consumer committed them.
    std::map<std::int64_t, int> times;  ///< How often each was delivered.
    std::int64_t first = 0;             ///< Messages before were committed in an earlier stream.
  };
  struct Peer {
    std::unique_ptr<StreamProducer> producer;
    Oracle oracle;
    std::int64_t known_at_restart = 0;  ///< What it knew to be committed when the consumer died.
  };

  std::vector<Peer> peers;
  std::unique_ptr<StreamConsumer> consumer;
  std::int64_t now = 1'000'000;
  std::size_t overflows = 0;  ///< Chunks lost because the receive buffer was full.
  std::size_t most_held = 0;
  int wrong = 0;  ///< Deliveries that differ from the oracle, or out of order.
  int restarts = 0;
  int again_after_commit = 0;  ///< Deliveries of what the producer knew to be committed before.

 private:
  void offer_more(Peer& peer);
  void move_chunks();
  template <class Message>
  std::optional<Message> damaged(std::optional<Message> message);
  void move_acks();
  void read();
  void deliver(StreamMessage message);
  void commit_due();
  std::int64_t next_event() const;

  Setup setup_;
  std::mt19937_64& rng_;
  SimWire<chunk_t> chunk_wire_;
  SimWire<ack_t> ack_wire_;
  std::vector<chunk_t> buffer_;  ///< The socket's.
  std::size_t buffered_ = 0;
  std::int64_t next_read_ = 0;
  std::int64_t next_take_ = 0;
  std::int64_t incarnation_ = 1;
  std::int64_t next_session_ = 1;
  std::map<std::int64_t, std::int64_t>
      last_number_;  ///< By session, delivered in this incarnation.
  struct Work {
    std::int64_t due, session, number;
  };
  std::vector<Work> work_;
};

}  // namespace voxatlas::test
