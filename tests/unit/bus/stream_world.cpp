#include "bus/stream_world.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "bus/credit.hpp"

namespace voxatlas::test {

StreamWorld::StreamWorld(const Setup& setup, std::mt19937_64& rng)
    : setup_(setup), rng_(rng), chunk_wire_(setup.chunks, rng), ack_wire_(setup.acks, rng) {
  setup_.consumer.receive_buffer_bytes = setup_.buffer_bytes;
  consumer = std::make_unique<StreamConsumer>(incarnation_, setup_.consumer);
  for (int i = 0; i < setup_.producers; ++i) {
    Peer peer;
    peer.producer = std::make_unique<StreamProducer>(next_session_++, setup_.stream);
    for (int m = 0; m < setup_.messages; ++m) {
      const auto range = setup_.most_bytes - setup_.least_bytes + 1;
      Bytes bytes(setup_.least_bytes +
                  (rng_() % 4 == 0 ? rng_() % std::min<std::size_t>(range, 100) : rng_() % range));
      for (std::size_t at = 0; at < bytes.size(); at += 997) {
        bytes[at] = static_cast<std::uint8_t>(rng_());
      }
      peer.oracle.offered.push_back(std::move(bytes));
    }
    peers.push_back(std::move(peer));
  }
}

void StreamWorld::offer_more(Peer& peer) {
  auto& producer = *peer.producer;
  while (producer.has_room()) {
    const auto number = peer.oracle.first + producer.offered_messages();
    if (number >= static_cast<std::int64_t>(peer.oracle.offered.size())) return;
    producer.offer(MessageKind::kScan, peer.oracle.offered[static_cast<std::size_t>(number)]);
  }
}

/// A wrong bit anywhere in the encoded message, now and then. What no decoder takes is lost.
template <class Message>
std::optional<Message> StreamWorld::damaged(std::optional<Message> message) {
  if (!message || std::uniform_real_distribution<double>()(rng_) >= setup_.damage) return message;
  auto bytes = encode_message(*message);
  // Half of them where the fields are, which are few beside the data.
  const auto range = rng_() % 2 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 72);
  bytes[rng_() % range] ^= static_cast<std::uint8_t>(1u << rng_() % 8);
  auto decoded = decode_message<Message>(bytes);
  return decoded ? std::optional(std::move(*decoded)) : std::nullopt;
}

void StreamWorld::move_chunks() {
  for (auto& peer : peers) {
    for (const auto& chunk : peer.producer->poll(now)) chunk_wire_.send(chunk, now);
  }
  while (auto sent = chunk_wire_.receive(now)) {
    auto chunk = damaged(std::move(sent));
    if (!chunk) continue;
    const auto cost =
        chunk->count == 0 ? 0 : buffer_cost(std::max<std::size_t>(1, chunk->data.size()));
    if (buffered_ + cost > setup_.buffer_bytes) {
      ++overflows;
      continue;
    }
    buffered_ += cost;
    buffer_.push_back(std::move(*chunk));
  }
}

void StreamWorld::read() {
  if (now < next_read_) return;
  next_read_ = now + setup_.read_every_us;
  for (auto& chunk : std::exchange(buffer_, {})) consumer->on_chunk(std::move(chunk), now);
  buffered_ = 0;
  most_held = std::max(most_held, consumer->held_bytes());
  if (now < next_take_) return;
  next_take_ = now + setup_.take_every_us;
  for (auto& message : consumer->take()) deliver(std::move(message));
}

void StreamWorld::deliver(StreamMessage message) {
  for (auto& peer : peers) {
    if (peer.producer->session() != message.session) continue;
    const auto number = peer.oracle.first + message.number;
    const auto expected = last_number_.find(message.session);
    // In order and without gaps, but for what an earlier incarnation has committed.
    const auto next = expected == last_number_.end() ? message.number : expected->second + 1;
    if (message.number < next) ++wrong;
    for (auto skipped = next; skipped < message.number; ++skipped) {
      if (!peer.oracle.committed.contains(peer.oracle.first + skipped)) ++wrong;
    }
    last_number_[message.session] = message.number;
    if (number < peer.known_at_restart) ++again_after_commit;
    if (message.payload != peer.oracle.offered[static_cast<std::size_t>(number)]) ++wrong;
    ++peer.oracle.times[number];
    work_.push_back({now + setup_.commit_after_us, message.session, message.number});
  }
}

void StreamWorld::commit_due() {
  for (auto it = work_.begin(); it != work_.end();) {
    if (it->due > now) {
      ++it;
      continue;
    }
    consumer->commit(it->session, it->number);
    for (auto& peer : peers) {
      if (peer.producer->session() == it->session) {
        peer.oracle.committed.insert(peer.oracle.first + it->number);
      }
    }
    it = work_.erase(it);
  }
}

void StreamWorld::move_acks() {
  for (const auto& ack : consumer->poll(now)) ack_wire_.send(ack, now);
  while (auto sent = ack_wire_.receive(now)) {
    const auto ack = damaged(std::move(sent));
    if (!ack) continue;
    for (auto& peer : peers) peer.producer->on_ack(*ack, now);
  }
}

std::int64_t StreamWorld::next_event() const {
  auto at =
      std::min({chunk_wire_.next_arrival(), ack_wire_.next_arrival(), consumer->next_poll(now)});
  if (!buffer_.empty()) at = std::min(at, next_read_);
  if (setup_.take_every_us > 0) at = std::min(at, std::max(now, next_take_));
  for (const auto& work : work_) at = std::min(at, work.due);
  for (const auto& peer : peers) {
    const auto offered = peer.oracle.first + peer.producer->offered_messages();
    const bool more = offered < static_cast<std::int64_t>(peer.oracle.offered.size());
    at = std::min(at, more && peer.producer->has_room() ? now : peer.producer->next_poll(now));
  }
  return at;
}

bool StreamWorld::step() {
  for (auto& peer : peers) offer_more(peer);
  if (done()) return false;
  move_chunks();
  read();
  commit_due();
  move_acks();
  const auto at = next_event();
  if (at == INT64_MAX) return false;  // Nobody would ever do anything again.
  now = std::max(now + 1, at);
  return true;
}

bool StreamWorld::run(std::int64_t most_us) {
  const auto end = now + most_us;
  while (now < end && step()) {
  }
  return done();
}

bool StreamWorld::done() const {
  for (const auto& peer : peers) {
    const auto committed = peer.oracle.first + peer.producer->committed_messages();
    if (committed < static_cast<std::int64_t>(peer.oracle.offered.size())) return false;
  }
  return true;
}

void StreamWorld::restart_consumer() {
  ++restarts;
  consumer = std::make_unique<StreamConsumer>(++incarnation_, setup_.consumer);
  work_.clear();
  while (chunk_wire_.receive(INT64_MAX)) {  // Nobody is there to receive what is under way.
  }
  buffer_.clear();
  buffered_ = 0;
  last_number_.clear();
  for (auto& peer : peers) {
    peer.known_at_restart = peer.oracle.first + peer.producer->committed_messages();
  }
}

void StreamWorld::restart_producer(std::size_t index) {
  ++restarts;
  auto& peer = peers[index];
  const auto kept = peer.oracle.first + peer.producer->committed_messages();
  const std::vector<Bytes> held = peer.producer->uncommitted();  // Its successor may go by them.
  if (!std::ranges::equal(
          held,
          std::span(peer.oracle.offered).subspan(static_cast<std::size_t>(kept), held.size()))) {
    ++wrong;
  }
  peer.oracle.first = kept;
  peer.producer = std::make_unique<StreamProducer>(next_session_++, setup_.stream);
}

}  // namespace voxatlas::test
