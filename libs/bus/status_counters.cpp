#include "bus/status_counters.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace voxatlas {

namespace {

double number(auto value) { return static_cast<double>(value); }

}  // namespace

void add_incoming(const StreamConsumer& consumer, StatusCounters& counters) {
  const auto& counted = consumer.counters();
  counters.emplace_back("in_held_bytes", number(consumer.held_bytes()));
  counters.emplace_back("in_credit", number(consumer.credit()));
  counters.emplace_back("in_producers", number(counted.active_producers));
  counters.emplace_back("in_chunks", number(counted.chunks));
  counters.emplace_back("in_gaps", number(counted.gaps_reported));
  counters.emplace_back("in_refused", number(counted.refused));
}

void add_outgoing(std::span<StreamProducer* const> producers, StatusCounters& counters) {
  std::size_t held = 0;
  std::int64_t credit = 0;
  std::uint64_t sent = 0, resent = 0;
  for (const auto* producer : producers) {
    held += producer->held_bytes();
    credit += producer->credit();
    sent += producer->counters().chunks_sent;
    resent += producer->counters().chunks_resent;
  }
  counters.emplace_back("out_held_bytes", number(held));
  counters.emplace_back("out_credit", number(credit));
  counters.emplace_back("out_chunks", number(sent));
  counters.emplace_back("out_resent", number(resent));
}

void SourceMarks::note(const std::string& source, std::int64_t session, std::int64_t seq) {
  Entry entry{source, session, seq};
  const auto known = std::ranges::find_if(entries_, [&](const Entry& other) {
    return other.source == source && other.session == session;
  });
  if (known != entries_.end()) {
    entry.seq = std::max(seq, known->seq);
    entries_.erase(known);
  }
  entries_.push_front(std::move(entry));
  if (entries_.size() > kMost) entries_.pop_back();
}

void SourceMarks::add_to(StatusCounters& counters) const {
  for (const auto& entry : entries_) {
    counters.emplace_back(fmt::format("seq {}/{}", entry.source, entry.session), number(entry.seq));
  }
}

}  // namespace voxatlas
