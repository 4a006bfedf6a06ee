#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "bus/ack_ranges.hpp"
#include "bus/stream_consumer.hpp"

namespace voxatlas {

/// One stream as its consumer sees it: chunks become messages, in order. StreamConsumer gives it
/// credit and decides when it is acknowledged.
///
/// Promise: take each chunk once, in any order; a chunk that contradicts an earlier one breaks the
///          stream for good.
class IncomingStream {
 public:
  /// `base` is the first chunk the producer still holds.
  IncomingStream(std::int64_t session, std::int64_t base);

  enum class Outcome { kTaken, kDuplicate, kBroken };
  /// A data chunk whose own fields, size and CRC are right. Whole messages go to `ready`.
  Outcome take(const chunk_t& head, ByteView data, std::size_t max_message_bytes,
               std::vector<StreamMessage>& ready);
  bool has(std::int64_t seq) const { return seq < next_ || pending_.contains(seq); }

  /// The producer says that everything below is committed: nothing of it will come any more.
  void skip_below(std::int64_t base);
  void seen_below(std::int64_t seq) { highest_ = std::max(highest_, seq); }
  void offered_below(std::int64_t seq) { offered_ = std::max(offered_, seq); }
  void commit(std::int64_t number);
  /// Frees what is not a whole message; it is missing again.
  void forget_pieces();

  std::vector<ChunkRange> gaps(std::size_t limit) const;
  bool has_gap() const { return highest_ > next_ + static_cast<std::int64_t>(pending_.size()); }

  std::int64_t session() const { return session_; }
  std::int64_t received() const { return next_; }
  std::int64_t committed() const { return committed_; }
  std::int64_t highest() const { return highest_; }
  std::int64_t offered() const { return offered_; }
  /// Chunks that have arrived, counted as if those below received() were all.
  std::int64_t arrived() const { return next_ + static_cast<std::int64_t>(pending_.size()); }
  std::size_t held_bytes() const { return pending_bytes_ + pieces_.size(); }
  bool in_pieces() const { return index_ > 0; }
  bool all_committed() const { return uncommitted_.empty() && index_ == 0 && pending_.empty(); }
  bool broken() const { return broken_; }

 private:
  struct Whole {
    std::int64_t number;
    std::int64_t end;  ///< The chunk after its last.
  };

  bool append(const chunk_t& head, ByteView data, std::size_t max_message_bytes,
              std::vector<StreamMessage>& ready);
  bool fits(const chunk_t& head) const;
  void drop_pieces();
  Outcome give_up();

  std::int64_t session_;
  std::int64_t next_;       ///< Every chunk below has arrived.
  std::int64_t committed_;  ///< Every chunk below is done with.
  std::int64_t highest_;    ///< Every chunk from here on was not sent yet, as far as is known.
  std::int64_t offered_;    ///< Chunks the producer has.
  std::map<std::int64_t, chunk_t> pending_;  ///< Beyond next_.
  std::size_t pending_bytes_ = 0;

  std::int64_t message_ = -1;  ///< Number of the message chunk next_ is of; -1: not known yet.
  std::int32_t index_ = 0;     ///< Of chunk next_ in it.
  std::int32_t count_ = 0;
  std::int16_t kind_ = 0;
  Bytes pieces_;  ///< Of that message, those before next_, one after another.
  std::deque<Whole> uncommitted_;
  bool broken_ = false;
};

}  // namespace voxatlas
