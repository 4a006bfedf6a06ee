#include "bus/incoming_stream.hpp"

#include <algorithm>
#include <utility>

namespace voxatlas {
namespace {

/// Only once all is there: a message is allocated by what came, not by what was announced, and a
/// vector that grew on the way would be copied again and again.
Bytes join(std::vector<Bytes>&& pieces, std::size_t bytes) {
  if (pieces.size() == 1) return std::move(pieces.front());
  Bytes whole;
  whole.reserve(bytes);
  for (auto& piece : pieces) {
    whole.insert(whole.end(), piece.begin(), piece.end());
    piece = Bytes();
  }
  return whole;
}

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
  if (!fits(chunk) || chunk.data.size() > max_message_bytes - pieces_bytes_) return false;
  if (index_ == 0) {
    message_ = chunk.message;
    count_ = chunk.count;
    kind_ = chunk.kind;
  }
  pieces_bytes_ += chunk.data.size();
  pieces_.push_back(std::move(chunk.data));
  ++next_;
  if (++index_ < count_) return true;
  ready.push_back({session_, message_, static_cast<MessageKind>(kind_),
                   join(std::move(pieces_), pieces_bytes_)});
  uncommitted_.push_back({message_, next_});
  drop_pieces();
  ++message_;
  return true;
}

void IncomingStream::drop_pieces() {
  index_ = 0;
  pieces_ = {};
  pieces_bytes_ = 0;
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
