#include "bus/stream_consumer.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "base/crc32c.hpp"
#include "bus/checksum.hpp"
#include "bus/credit.hpp"
#include "bus/incoming_stream.hpp"
#include "bus/stream_producer.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kMaxStreams = 1024;
constexpr std::int64_t kAckDelayUs = 250;  ///< Arrivals wait this long to be acknowledged together.
constexpr std::int64_t kGapAgainUs = 1'000;
constexpr std::int64_t kGapAgainMaxUs = 500'000;
constexpr std::int64_t kActiveUs = 1'000'000;

struct Source {
  IncomingStream stream;
  CreditAccount account{};
  bool ack_now = false;
  std::int64_t unacked = 0;        ///< Chunks that arrived since the last acknowledgement,
  std::int64_t unacked_since = 0;  ///< and when the first of them did.
  std::int64_t gap_told_at = 0;
  std::int64_t gap_again_us = kGapAgainUs;
};

}  // namespace

struct StreamConsumer::State {
  State(std::int64_t i, const ConsumerConfig& c) : incarnation(i), config(c) {}

  Source* source_of(const chunk_t& chunk);
  bool make_room_for_stream();
  void take_data(Source& source, const chunk_t& head, ByteView data, std::int64_t now);
  bool acceptable(const Source& source, const chunk_t& chunk) const;
  void settle(Source& source);
  void forget_silent(std::int64_t now);
  void grant(std::int64_t now);
  bool ack_due(const Source& source, std::int64_t now) const;
  std::int64_t ack_at(const Source& source) const;
  ack_t acknowledge(Source& source, std::int64_t now);

  std::int64_t incarnation;
  ConsumerConfig config;
  std::map<std::int64_t, Source> sources;  ///< By session.
  std::vector<StreamMessage> ready;
  std::size_t ready_bytes = 0;
  std::size_t pieces_bytes = 0;  ///< Held by all streams.
  std::uint64_t turns = 0;
  Counters counters;
};

/// Forgets the stream silent for longest of those that owe and are owed nothing.
bool StreamConsumer::State::make_room_for_stream() {
  if (sources.size() < kMaxStreams) return true;
  auto oldest = sources.end();
  for (auto it = sources.begin(); it != sources.end(); ++it) {
    if (!it->second.stream.all_committed() && !it->second.stream.broken()) continue;
    if (oldest == sources.end() || it->second.account.heard_at < oldest->second.account.heard_at) {
      oldest = it;
    }
  }
  if (oldest == sources.end()) return false;
  sources.erase(oldest);
  return true;
}

Source* StreamConsumer::State::source_of(const chunk_t& chunk) {
  const auto known = sources.find(chunk.session);
  if (known != sources.end()) return &known->second;
  if (!make_room_for_stream()) return nullptr;
  auto [it, added] =
      sources.emplace(chunk.session, Source{IncomingStream(chunk.session, chunk.base)});
  it->second.account.credit = chunk.base;
  return &it->second;
}

/// What was granted, and, for what an earlier incarnation granted, a receive buffer beyond. Whoever
/// keeps to its credit never meets the bound on what is held.
bool StreamConsumer::State::acceptable(const Source& source, const chunk_t& chunk) const {
  const auto most =
      config.max_held_bytes + config.max_message_bytes + 2 * config.receive_buffer_bytes;
  if (ready_bytes + pieces_bytes > most) return false;
  const auto buffer = static_cast<std::int64_t>(
      config.receive_buffer_bytes / buffer_cost(source.account.chunk_bytes) + 1);
  return chunk.seq < std::max(source.account.accept_below, source.stream.received() + buffer);
}

void StreamConsumer::State::take_data(Source& source, const chunk_t& head, ByteView data,
                                      std::int64_t now) {
  if (source.stream.has(head.seq)) {
    ++counters.duplicates;
    source.ack_now = true;
    return;
  }
  if (!acceptable(source, head)) {
    ++counters.refused;
    return;
  }
  ++counters.chunks;
  if (head.index + 1 < head.count) {  // Only a chunk that another follows is as large as can be.
    source.account.chunk_bytes = std::max(source.account.chunk_bytes, data.size());
  }
  if (head.seq > source.stream.highest()) source.ack_now = true;  // A gap, just now.
  if (source.unacked++ == 0) source.unacked_since = now;
  source.gap_again_us = kGapAgainUs;
  const auto messages = ready.size();
  const auto held = source.stream.held_bytes();
  const auto outcome = source.stream.take(head, data, config.max_message_bytes, ready);
  pieces_bytes = pieces_bytes - held + source.stream.held_bytes();
  for (auto i = messages; i < ready.size(); ++i) ready_bytes += ready[i].payload.size();
  counters.messages += ready.size() - messages;
  if (outcome == IncomingStream::Outcome::kBroken) ++counters.refused;
}

/// Brings the books up to what the stream has.
void StreamConsumer::State::settle(Source& source) {
  source.account.arrived = source.stream.arrived();
  source.account.offered = source.stream.offered();
}

StreamConsumer::StreamConsumer(std::int64_t incarnation, const ConsumerConfig& config)
    : state_(std::make_unique<State>(incarnation, config)) {}
StreamConsumer::~StreamConsumer() = default;

void StreamConsumer::on_chunk(const chunk_t& chunk, std::int64_t now) {
  on_chunk(chunk, chunk.data, now);
}

void StreamConsumer::on_chunk(const chunk_t& head, ByteView data, std::int64_t now) {
  auto& state = *state_;
  if (state.config.client != 0 && !is_session_of(head.session, state.config.client)) return;
  const bool sound = head.size >= 0 && static_cast<std::size_t>(head.size) == data.size() &&
                     check_fields(head).has_value() && checksum(head, crc32c(data)) == head.crc;
  auto* source = sound ? state.source_of(head) : nullptr;
  if (source == nullptr || source->stream.broken()) {
    ++state.counters.refused;
    return;
  }
  source->account.heard_at = now;
  const auto held = source->stream.held_bytes();
  source->stream.skip_below(head.base);
  state.pieces_bytes = state.pieces_bytes - held + source->stream.held_bytes();
  source->stream.offered_below(head.offered);
  if (head.count == 0) {
    source->stream.seen_below(head.seq);
    source->ack_now = true;
  } else {
    state.take_data(*source, head, data, now);
  }
  state.settle(*source);
}

std::vector<StreamMessage> StreamConsumer::take() {
  state_->ready_bytes = 0;
  return std::exchange(state_->ready, {});
}

void StreamConsumer::commit(std::int64_t session, std::int64_t number) {
  const auto known = state_->sources.find(session);
  if (known == state_->sources.end()) return;
  auto& stream = known->second.stream;
  const auto before = stream.committed();
  stream.commit(number);
  if (stream.committed() > before) known->second.ack_now = true;
}

/// A producer that has been silent for long is gone, or will say again what it has.
void StreamConsumer::State::forget_silent(std::int64_t now) {
  for (auto it = sources.begin(); it != sources.end();) {
    auto& stream = it->second.stream;
    if (now - it->second.account.heard_at < config.producer_timeout_us) {
      ++it;
      continue;
    }
    pieces_bytes -= stream.held_bytes();
    stream.forget_pieces();
    settle(it->second);
    it = stream.all_committed() || stream.broken() ? sources.erase(it) : std::next(it);
  }
}

/// Divides the receive buffer. Where too much is held, nobody gets any until messages are taken;
/// where none is whole, one stream goes on, so that its message becomes so.
void StreamConsumer::State::grant(std::int64_t now) {
  const bool full = ready_bytes + pieces_bytes >= config.max_held_bytes;
  std::vector<CreditAccount*> accounts;
  const Source* only = nullptr;
  for (auto& [session, source] : sources) {
    if (source.stream.broken()) continue;
    lapse_credit(source.account, now);
    accounts.push_back(&source.account);
    if (only == nullptr || source.stream.held_bytes() > only->stream.held_bytes()) only = &source;
  }
  if (full && !ready.empty()) return;
  if (full) std::erase_if(accounts, [&](const auto* account) { return account != &only->account; });
  divide_credit(accounts, config.receive_buffer_bytes, now, turns);
}

std::int64_t StreamConsumer::State::ack_at(const Source& source) const {
  if (source.ack_now || source.account.granted) return 0;
  auto at = kNever;
  if (source.unacked > 0) {
    const auto batch = source.account.outstanding() / 4;
    at = source.unacked > batch ? 0 : source.unacked_since + kAckDelayUs;
  }
  if (source.stream.has_gap()) at = std::min(at, source.gap_told_at + source.gap_again_us);
  return at;
}

bool StreamConsumer::State::ack_due(const Source& source, std::int64_t now) const {
  return !source.stream.broken() && ack_at(source) <= now;
}

ack_t StreamConsumer::State::acknowledge(Source& source, std::int64_t now) {
  ack_t ack{};
  ack.session = source.stream.session();
  ack.incarnation = incarnation;
  ack.received = source.stream.received();
  ack.committed = source.stream.committed();
  ack.credit = source.account.credit;
  if (source.stream.has_gap()) {
    set_ranges(ack, source.stream.gaps(kMaxGaps));
    counters.gaps_reported += static_cast<std::uint64_t>(ack.gaps);
    source.gap_told_at = now;
    source.gap_again_us = std::min(2 * source.gap_again_us, kGapAgainMaxUs);
  }
  ack.crc = checksum(ack);
  source.account.told_at = now;
  source.account.granted = false;
  source.ack_now = false;
  source.unacked = 0;
  ++counters.acks_sent;
  return ack;
}

std::vector<ack_t> StreamConsumer::poll(std::int64_t now) {
  auto& state = *state_;
  state.forget_silent(now);
  state.grant(now);
  std::vector<ack_t> acks;
  state.counters.active_producers = 0;
  for (auto& [session, source] : state.sources) {
    if (now - source.account.heard_at < kActiveUs) ++state.counters.active_producers;
    if (state.ack_due(source, now)) acks.push_back(state.acknowledge(source, now));
  }
  return acks;
}

std::int64_t StreamConsumer::next_poll(std::int64_t now) const {
  auto at = kNever;
  for (const auto& [session, source] : state_->sources) {
    if (source.stream.broken()) continue;
    at = std::min(at, state_->ack_at(source));
    if (source.stream.in_pieces() || source.stream.held_bytes() > 0) {
      at = std::min(at, source.account.heard_at + state_->config.producer_timeout_us);
    }
    const auto lapse = source.account.told_at + kCreditCountsUs + 1;
    if (source.account.outstanding() > 0 && lapse > now) at = std::min(at, lapse);
  }
  return at == kNever ? at : std::max(at, now);
}

std::size_t StreamConsumer::held_bytes() const {
  return state_->ready_bytes + state_->pieces_bytes;
}

std::int64_t StreamConsumer::credit() const {
  std::int64_t chunks = 0;
  for (const auto& [session, source] : state_->sources) chunks += source.account.outstanding();
  return chunks;
}

const StreamConsumer::Counters& StreamConsumer::counters() const { return state_->counters; }

}  // namespace voxatlas
