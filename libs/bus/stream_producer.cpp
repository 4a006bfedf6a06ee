#include "bus/stream_producer.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <set>
#include <utility>

#include "base/check.hpp"
#include "base/crc32c.hpp"
#include "bus/ack_ranges.hpp"
#include "bus/checksum.hpp"
#include "bus/requests.hpp"
#include "bus/send_window.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kCreditLapsesUs = 100'000;
/// A gap may be reported again before its retransmission has arrived: only a later report is news.
constexpr std::int64_t kResendAgainUs = 700;
constexpr std::size_t kPastIncarnations = 16;
constexpr std::int64_t kIncarnationGoneUs = 500'000;
constexpr std::int64_t kClientBits = ~std::int64_t{0xffff};

struct HeldChunk {
  chunk_t chunk;
  std::uint32_t data_crc;
  std::int64_t sent_at = 0;
  bool resent = false;
};

struct HeldMessage {
  std::int64_t end;  ///< The chunk after its last.
  std::size_t bytes;
};

}  // namespace

struct StreamProducer::State {
  State(std::int64_t s, const StreamConfig& c) : session(s), config(c) {}

  std::int64_t base() const { return offered - static_cast<std::int64_t>(chunks.size()); }
  HeldChunk& at(std::int64_t seq) { return chunks[static_cast<std::size_t>(seq - base())]; }

  bool accept_incarnation(const ack_t& ack, std::int64_t now);
  bool free_committed(std::int64_t committed);
  void resend(const ack_t& ack, std::int64_t now);
  std::int64_t may_send_below(std::int64_t now) const;
  const chunk_t& prepare(std::int64_t seq, std::int64_t now);
  bool probe_wanted(std::int64_t now) const;
  chunk_t probe(std::int64_t now);
  bool wants_credit(std::int64_t now) const;
  std::int64_t probe_due() const;

  std::int64_t session;
  StreamConfig config;

  std::deque<HeldChunk> chunks;  ///< base() .. offered - 1.
  std::deque<HeldMessage> messages;
  std::size_t held_bytes = 0;
  std::int64_t offered = 0;  ///< Chunks so far.
  std::int64_t offered_messages = 0;
  std::int64_t next = 0;        ///< The first chunk this incarnation was not sent.
  std::int64_t sent_below = 0;  ///< The first chunk nobody was ever sent.
  std::int64_t told = 0;        ///< The most chunks the consumer was told of.
  std::int64_t received = 0;
  std::int64_t credit = 0;
  std::set<std::int64_t> missing;  ///< To send again.
  SendWindow window;

  std::int64_t incarnation = 0;
  std::deque<std::int64_t> past_incarnations;
  std::int64_t current_heard = 0;  ///< When this incarnation was.
  std::int64_t last_heard = 0;
  std::int64_t last_sent = 0;
  std::int64_t silence_us = 0;  ///< How long to wait before the next probe.
  bool asked = false;           ///< A probe is out that no acknowledgement has followed.
  Counters counters;
};

/// An incarnation that is new starts from what its first acknowledgement says; one that an other
/// has followed is only believed what it made durable. Which of two came later is a guess where
/// acknowledgements overtake one another: the one that goes on speaking is right.
bool StreamProducer::State::accept_incarnation(const ack_t& ack, std::int64_t now) {
  const auto heard = std::exchange(current_heard, now);
  if (ack.incarnation == incarnation) return true;
  const auto past = std::ranges::find(past_incarnations, ack.incarnation);
  if (past != past_incarnations.end()) {
    if (now - heard < kIncarnationGoneUs) {
      current_heard = heard;
      return false;
    }
    past_incarnations.erase(past);
  }
  if (incarnation != 0) {
    ++counters.consumer_restarts;
    past_incarnations.push_back(incarnation);
    if (past_incarnations.size() > kPastIncarnations) past_incarnations.pop_front();
  }
  incarnation = ack.incarnation;
  received = std::max(ack.received, base());
  next = received;
  credit = ack.credit;
  told = 0;
  missing.clear();
  window = SendWindow();
  return true;
}

/// Whole messages only: the consumer commits messages.
bool StreamProducer::State::free_committed(std::int64_t committed) {
  bool freed = false;
  while (!messages.empty() && messages.front().end <= committed) {
    const auto end = messages.front().end;
    held_bytes -= messages.front().bytes;
    messages.pop_front();
    chunks.erase(chunks.begin(), chunks.begin() + (end - base()));
    freed = true;
  }
  received = std::max(received, base());
  next = std::max(next, received);
  missing.erase(missing.begin(), missing.lower_bound(base()));
  return freed;
}

void StreamProducer::State::resend(const ack_t& ack, std::int64_t now) {
  for (const auto& range : ranges_of(ack)) {
    const auto end = std::min(range.end, next);
    for (auto seq = std::max(range.first, base()); seq < end; ++seq) {
      auto& held = at(seq);
      if (held.resent && now - held.sent_at < kResendAgainUs) continue;
      held.resent = true;
      if (missing.insert(seq).second) window.lost(now);
    }
  }
}

std::int64_t StreamProducer::State::may_send_below(std::int64_t now) const {
  if (now - last_heard > kCreditLapsesUs) return next;
  return std::min({credit, offered, received + window.chunks()});
}

const chunk_t& StreamProducer::State::prepare(std::int64_t seq, std::int64_t now) {
  auto& held = at(seq);
  held.chunk.base = base();
  held.chunk.offered = offered;
  held.chunk.crc = checksum(held.chunk, held.data_crc);
  held.sent_at = now;
  told = std::max(told, offered);
  ++counters.chunks_sent;
  return held.chunk;
}

bool StreamProducer::State::probe_wanted(std::int64_t now) const {
  return !chunks.empty() && (wants_credit(now) || now >= probe_due());
}

chunk_t StreamProducer::State::probe(std::int64_t now) {
  told = std::max(told, offered);
  asked = true;
  last_sent = now;
  silence_us = std::clamp(2 * silence_us, config.rto_us, config.rto_max_us);
  ++counters.probes;
  chunk_t chunk{};
  chunk.session = session;
  chunk.seq = next;
  chunk.base = base();
  chunk.offered = offered;
  chunk.message = offered_messages - static_cast<std::int64_t>(messages.size());
  chunk.crc = checksum(chunk);
  return chunk;
}

/// Whether the consumer has no way to know that more chunks wait.
bool StreamProducer::State::wants_credit(std::int64_t now) const {
  if (asked || next >= offered) return false;
  return now - last_heard > kCreditLapsesUs || (next >= credit && told <= credit);
}

std::int64_t StreamProducer::State::probe_due() const {
  return std::max(last_heard, last_sent) + silence_us;
}

StreamProducer::StreamProducer(std::int64_t session, const StreamConfig& config)
    : state_(std::make_unique<State>(session, config)) {
  VOX_CHECK(config.chunk_bytes > 0 && config.rto_us > 0 && config.rto_max_us >= config.rto_us);
}
StreamProducer::~StreamProducer() = default;

bool StreamProducer::has_room() const {
  return state_->chunks.empty() || state_->held_bytes < state_->config.send_buffer_bytes;
}

std::int64_t StreamProducer::offer(MessageKind kind, Bytes payload) {
  VOX_CHECK(has_room());
  auto& state = *state_;
  const auto step = state.config.chunk_bytes;
  const auto bytes = payload.size();
  const auto count = std::max<std::size_t>(1, (bytes + step - 1) / step);
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = i * step;
    const auto last = std::min(bytes, first + step);
    chunk_t chunk{};
    chunk.session = state.session;
    chunk.seq = state.offered++;
    chunk.message = state.offered_messages;
    chunk.index = static_cast<std::int32_t>(i);
    chunk.count = static_cast<std::int32_t>(count);
    chunk.kind = static_cast<std::int16_t>(kind);
    chunk.size = static_cast<std::int32_t>(last - first);
    if (count == 1) {
      chunk.data = std::move(payload);
    } else {
      chunk.data.assign(payload.begin() + static_cast<std::ptrdiff_t>(first),
                        payload.begin() + static_cast<std::ptrdiff_t>(last));
    }
    const auto data_crc = crc32c(chunk.data);
    state.chunks.push_back({std::move(chunk), data_crc});
  }
  state.held_bytes += bytes;
  state.messages.push_back({state.offered, bytes});
  return state.offered_messages++;
}

void StreamProducer::on_ack(const ack_t& ack, std::int64_t now) {
  auto& state = *state_;
  if (ack.session != state.session) return;
  if (ack.crc != checksum(ack) || ack.received > state.sent_below || ack.committed > ack.received ||
      ack.committed < 0) {
    ++state.counters.acks_refused;
    return;
  }
  ++state.counters.acks;
  const bool lapsed = now - state.last_heard > kCreditLapsesUs;
  state.last_heard = now;
  state.asked = false;
  const bool current = state.accept_incarnation(ack, now);
  const bool freed = state.free_committed(ack.committed);
  if (!current) return;
  const bool news = freed || ack.received > state.received || ack.credit > state.credit;
  if (news || ack.gaps > 0) state.silence_us = state.config.rto_us;
  if (ack.received > state.received) {
    state.window.arrived(ack.received - state.received);
    state.received = ack.received;
    state.next = std::max(state.next, state.received);
  }
  state.credit = lapsed ? ack.credit : std::max(state.credit, ack.credit);
  state.resend(ack, now);
}

std::size_t StreamProducer::poll(std::int64_t now, std::size_t limit,
                                 const std::function<bool(const chunk_t&)>& send) {
  auto& state = *state_;
  std::size_t sent = 0;
  bool more = limit > 0;
  const auto pass = [&](std::int64_t seq, bool again) {
    if (again) ++state.counters.chunks_resent;
    more = send(state.prepare(seq, now)) && ++sent < limit;
  };
  while (more && !state.missing.empty()) {
    const auto seq = *state.missing.begin();
    state.missing.erase(state.missing.begin());
    pass(seq, true);
  }
  for (const auto end = state.may_send_below(now); more && state.next < end;) {
    const auto seq = state.next++;
    const bool again = seq < state.sent_below;
    state.sent_below = std::max(state.sent_below, state.next);
    pass(seq, again);
  }
  if (sent > 0) {
    state.silence_us = state.config.rto_us;
    state.last_sent = now;
  } else if (more && state.probe_wanted(now)) {
    send(state.probe(now));
    ++sent;
  }
  return sent;
}

std::vector<chunk_t> StreamProducer::poll(std::int64_t now, std::size_t limit) {
  std::vector<chunk_t> chunks;
  poll(now, limit, [&](const chunk_t& chunk) {
    chunks.push_back(chunk);
    return true;
  });
  return chunks;
}

std::int64_t StreamProducer::next_poll(std::int64_t now) const {
  const auto& state = *state_;
  if (state.chunks.empty()) return kNever;
  if (!state.missing.empty() || state.next < state.may_send_below(now)) return now;
  if (state.wants_credit(now)) return now;
  return std::max(now, state.probe_due());
}

std::int64_t StreamProducer::session() const { return state_->session; }
std::int64_t StreamProducer::committed_messages() const {
  return state_->offered_messages - static_cast<std::int64_t>(state_->messages.size());
}
std::int64_t StreamProducer::offered_messages() const { return state_->offered_messages; }
std::vector<Bytes> StreamProducer::uncommitted() const {
  std::vector<Bytes> payloads;
  auto chunk = state_->chunks.begin();
  for (const auto& message : state_->messages) {
    auto& payload = payloads.emplace_back();
    payload.reserve(message.bytes);
    for (; chunk != state_->chunks.end() && chunk->chunk.seq < message.end; ++chunk) {
      payload.insert(payload.end(), chunk->chunk.data.begin(), chunk->chunk.data.end());
    }
  }
  return payloads;
}
std::size_t StreamProducer::held_bytes() const { return state_->held_bytes; }
std::int64_t StreamProducer::credit() const {
  return std::max<std::int64_t>(0, state_->credit - state_->next);
}
std::int64_t StreamProducer::last_heard() const { return state_->last_heard; }
const StreamProducer::Counters& StreamProducer::counters() const { return state_->counters; }

std::int64_t client_session(std::int64_t client) {
  return (client & kClientBits) | (random_id() & ~kClientBits);
}

bool is_session_of(std::int64_t session, std::int64_t client) {
  return (session & kClientBits) == (client & kClientBits);
}

}  // namespace voxatlas
