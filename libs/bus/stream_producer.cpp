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
#include "bus/send_queue.hpp"
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

}  // namespace

struct StreamProducer::State {
  State(std::int64_t s, const StreamConfig& c) : session(s), config(c), queue(s, c.chunk_bytes) {}

  bool accept_incarnation(const ack_t& ack, std::int64_t now);
  bool free_committed(std::int64_t committed);
  void resend(const ack_t& ack, std::int64_t now);
  std::int64_t may_send_below(std::int64_t now) const;
  const SendQueue::Chunk& prepare(std::int64_t seq, std::int64_t now);
  bool probe_wanted(std::int64_t now) const;
  chunk_t probe(std::int64_t now);
  bool wants_credit(std::int64_t now) const;
  std::int64_t probe_due() const;

  std::int64_t session;
  StreamConfig config;

  SendQueue queue;
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
  received = std::max(ack.received, queue.base());
  next = received;
  credit = ack.credit;
  told = 0;
  missing.clear();
  window = SendWindow();
  return true;
}

bool StreamProducer::State::free_committed(std::int64_t committed) {
  const bool freed = queue.free_below(committed);
  received = std::max(received, queue.base());
  next = std::max(next, received);
  missing.erase(missing.begin(), missing.lower_bound(queue.base()));
  return freed;
}

void StreamProducer::State::resend(const ack_t& ack, std::int64_t now) {
  for (const auto& range : ranges_of(ack)) {
    const auto end = std::min(range.end, next);
    for (auto seq = std::max(range.first, queue.base()); seq < end; ++seq) {
      auto& held = queue.at(seq);
      if (held.resent && now - held.sent_at < kResendAgainUs) continue;
      held.resent = true;
      if (missing.insert(seq).second) window.lost(now);
    }
  }
}

std::int64_t StreamProducer::State::may_send_below(std::int64_t now) const {
  if (now - last_heard > kCreditLapsesUs) return next;
  return std::min({credit, queue.offered(), received + window.chunks()});
}

const SendQueue::Chunk& StreamProducer::State::prepare(std::int64_t seq, std::int64_t now) {
  auto& held = queue.at(seq);
  if (!held.data_crc) held.data_crc = crc32c(held.data);
  held.head.base = queue.base();
  held.head.offered = queue.offered();
  held.head.crc = checksum(held.head, *held.data_crc);
  held.sent_at = now;
  told = std::max(told, queue.offered());
  ++counters.chunks_sent;
  return held;
}

bool StreamProducer::State::probe_wanted(std::int64_t now) const {
  return !queue.empty() && (wants_credit(now) || now >= probe_due());
}

chunk_t StreamProducer::State::probe(std::int64_t now) {
  told = std::max(told, queue.offered());
  asked = true;
  last_sent = now;
  silence_us = std::clamp(2 * silence_us, config.rto_us, config.rto_max_us);
  ++counters.probes;
  chunk_t chunk{};
  chunk.session = session;
  chunk.seq = next;
  chunk.base = queue.base();
  chunk.offered = queue.offered();
  chunk.message = queue.committed_messages();
  chunk.crc = checksum(chunk);
  return chunk;
}

/// Whether the consumer has no way to know that more chunks wait.
bool StreamProducer::State::wants_credit(std::int64_t now) const {
  if (asked || next >= queue.offered()) return false;
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
  return state_->queue.empty() || state_->queue.held_bytes() < state_->config.send_buffer_bytes;
}

std::int64_t StreamProducer::offer(MessageKind kind, Bytes payload) {
  VOX_CHECK(has_room());
  return state_->queue.push(kind, std::move(payload));
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

std::size_t StreamProducer::poll(std::int64_t now, std::size_t limit, const Send& send) {
  auto& state = *state_;
  std::size_t sent = 0;
  bool more = limit > 0;
  const auto pass = [&](std::int64_t seq, bool again) {
    if (again) ++state.counters.chunks_resent;
    const auto& chunk = state.prepare(seq, now);
    more = send(chunk.head, chunk.data) && ++sent < limit;
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
    send(state.probe(now), {});
    ++sent;
  }
  return sent;
}

std::vector<chunk_t> StreamProducer::poll(std::int64_t now, std::size_t limit) {
  std::vector<chunk_t> chunks;
  poll(now, limit, [&](const chunk_t& head, ByteView data) {
    chunks.push_back(head);
    chunks.back().data.assign(data.begin(), data.end());
    return true;
  });
  return chunks;
}

std::int64_t StreamProducer::next_poll(std::int64_t now) const {
  const auto& state = *state_;
  if (state.queue.empty()) return kNever;
  if (!state.missing.empty() || state.next < state.may_send_below(now)) return now;
  if (state.wants_credit(now)) return now;
  return std::max(now, state.probe_due());
}

std::int64_t StreamProducer::session() const { return state_->session; }
std::int64_t StreamProducer::committed_messages() const {
  return state_->queue.committed_messages();
}
std::int64_t StreamProducer::offered_messages() const { return state_->queue.offered_messages(); }
std::vector<Bytes> StreamProducer::uncommitted() const { return state_->queue.payloads(); }
std::size_t StreamProducer::held_bytes() const { return state_->queue.held_bytes(); }
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
