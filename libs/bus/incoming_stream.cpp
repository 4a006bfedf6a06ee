#include "bus/incoming_stream.hpp"

#include <algorithm>
#include <utility>

namespace voxatlas {
namespace {

/// The most that is reserved for a message on the word of its first chunk. What nothing is written
/// to costs addresses, no memory.
constexpr std::size_t kMostReserved = std::size_t{8} << 20;

}  // namespace

IncomingStream::IncomingStream(std::int64_t session, std::int64_t base)
    : session_(session), next_(base), committed_(base), highest_(base), offered_(base) {}

IncomingStream::Outcome IncomingStream::take(const chunk_t& head, ByteView data,
                                             std::size_t max_message_bytes,
                                             std::vector<StreamMessage>& ready) {
  if (has(head.seq)) return Outcome::kDuplicate;
  seen_below(head.seq + 1);
  if (head.seq != next_) {
    chunk_t kept = head;
    kept.data.assign(data.begin(), data.end());
    pending_bytes_ += data.size();
    pending_.emplace(head.seq, std::move(kept));
    return Outcome::kTaken;
  }
  if (!append(head, data, max_message_bytes, ready)) return give_up();
  while (!pending_.empty() && pending_.begin()->first == next_) {
    const auto piece = std::move(pending_.extract(pending_.begin()).mapped());
    pending_bytes_ -= piece.data.size();
    if (!append(piece, piece.data, max_message_bytes, ready)) return give_up();
  }
  return Outcome::kTaken;
}

bool IncomingStream::fits(const chunk_t& head) const {
  if (index_ == 0) return head.index == 0 && (message_ < 0 || head.message == message_);
  return head.index == index_ && head.message == message_ && head.count == count_ &&
         head.kind == kind_;
}

bool IncomingStream::append(const chunk_t& head, ByteView data, std::size_t max_message_bytes,
                            std::vector<StreamMessage>& ready) {
  if (!fits(head) || data.size() > max_message_bytes - pieces_.size()) return false;
  if (index_ == 0) {
    message_ = head.message;
    count_ = head.count;
    kind_ = head.kind;
    const auto announced = static_cast<std::size_t>(count_) * data.size();
    pieces_.reserve(std::min({announced, max_message_bytes, kMostReserved}));
  }
  pieces_.insert(pieces_.end(), data.begin(), data.end());
  ++next_;
  if (++index_ < count_) return true;
  ready.push_back({session_, message_, static_cast<MessageKind>(kind_), std::move(pieces_)});
  uncommitted_.push_back({message_, next_});
  drop_pieces();
  ++message_;
  return true;
}

void IncomingStream::drop_pieces() {
  index_ = 0;
  pieces_ = {};
}

IncomingStream::Outcome IncomingStream::give_up() {
  broken_ = true;
  drop_pieces();
  pending_.clear();
  pending_bytes_ = 0;
  return Outcome::kBroken;
}

void IncomingStream::skip_below(std::int64_t base) {
  if (base <= committed_) return;
  committed_ = base;
  while (!uncommitted_.empty() && uncommitted_.front().end <= base) uncommitted_.pop_front();
  if (base <= next_) return;
  drop_pieces();
  message_ = -1;
  next_ = base;
  seen_below(base);
  offered_below(base);
  pending_.clear();  // What of it is beyond base is asked for again: this is rare.
  pending_bytes_ = 0;
}

void IncomingStream::commit(std::int64_t number) {
  while (!uncommitted_.empty() && uncommitted_.front().number <= number) {
    committed_ = std::max(committed_, uncommitted_.front().end);
    uncommitted_.pop_front();
  }
}

void IncomingStream::forget_pieces() {
  next_ = std::max(next_ - index_, committed_);
  drop_pieces();
  pending_.clear();
  pending_bytes_ = 0;
}

std::vector<ChunkRange> IncomingStream::gaps(std::size_t limit) const {
  std::vector<ChunkRange> ranges;
  auto first = next_;
  for (const auto& [seq, chunk] : pending_) {
    if (seq > first) ranges.push_back({first, seq});
    if (ranges.size() == limit) return ranges;
    first = seq + 1;
  }
  if (first < highest_) ranges.push_back({first, highest_});
  return ranges;
}

}  // namespace voxatlas
