#include "bus/incoming_stream.hpp"

#include <algorithm>
#include <utility>

namespace voxatlas {
namespace {

/// Room made at once for a message that is said to be large; it grows with what arrives.
constexpr std::size_t kReserveBytes = std::size_t{1} << 20;

}  // namespace

IncomingStream::IncomingStream(std::int64_t session, std::int64_t base)
    : session_(session), next_(base), committed_(base), highest_(base), offered_(base) {}

IncomingStream::Outcome IncomingStream::take(chunk_t&& chunk, std::size_t max_message_bytes,
                                             std::vector<StreamMessage>& ready) {
  if (has(chunk.seq)) return Outcome::kDuplicate;
  seen_below(chunk.seq + 1);
  if (chunk.seq != next_) {
    pending_bytes_ += chunk.data.size();
    pending_.emplace(chunk.seq, std::move(chunk));
    return Outcome::kTaken;
  }
  if (!append(std::move(chunk), max_message_bytes, ready)) return give_up();
  while (!pending_.empty() && pending_.begin()->first == next_) {
    auto piece = std::move(pending_.extract(pending_.begin()).mapped());
    pending_bytes_ -= piece.data.size();
    if (!append(std::move(piece), max_message_bytes, ready)) return give_up();
  }
  return Outcome::kTaken;
}

bool IncomingStream::fits(const chunk_t& chunk) const {
  if (index_ == 0) return chunk.index == 0 && (message_ < 0 || chunk.message == message_);
  return chunk.index == index_ && chunk.message == message_ && chunk.count == count_ &&
         chunk.kind == kind_;
}

bool IncomingStream::append(chunk_t&& chunk, std::size_t max_message_bytes,
                            std::vector<StreamMessage>& ready) {
  if (!fits(chunk) || chunk.data.size() > max_message_bytes - partial_.size()) return false;
  if (index_ == 0) {
    message_ = chunk.message;
    count_ = chunk.count;
    kind_ = chunk.kind;
    partial_ = std::move(chunk.data);
    const auto announced = partial_.size() * static_cast<std::size_t>(count_);
    if (count_ > 1) partial_.reserve(std::min(announced, kReserveBytes));
  } else {
    partial_.insert(partial_.end(), chunk.data.begin(), chunk.data.end());
  }
  ++next_;
  if (++index_ < count_) return true;
  ready.push_back({session_, message_, static_cast<MessageKind>(kind_), std::move(partial_)});
  uncommitted_.push_back({message_, next_});
  partial_ = Bytes();
  index_ = 0;
  ++message_;
  return true;
}

IncomingStream::Outcome IncomingStream::give_up() {
  broken_ = true;
  partial_ = Bytes();
  pending_.clear();
  pending_bytes_ = 0;
  return Outcome::kBroken;
}

void IncomingStream::skip_below(std::int64_t base) {
  if (base <= committed_) return;
  committed_ = base;
  while (!uncommitted_.empty() && uncommitted_.front().end <= base) uncommitted_.pop_front();
  if (base <= next_) return;
  partial_ = Bytes();
  index_ = 0;
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
  index_ = 0;
  partial_ = Bytes();
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
