#include "cli/publisher.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/check.hpp"
#include "base/log.hpp"
#include "bus/channels.hpp"

namespace voxatlas {

/// Publisher bounds what is held: a scan that must move may not wait for room, because what fills
/// it may be waiting for that very scan.
static StreamConfig unbounded() {
  StreamConfig config;
  config.send_buffer_bytes = std::numeric_limits<std::size_t>::max();
  return config;
}

std::int64_t Publisher::Ingest::last_heard() const {
  return std::max(ready_at, link->producer().last_heard());
}

bool Publisher::Ingest::is_there(std::int64_t now) const {
  return now - std::max(known_since, last_heard()) < kGoneUs;
}

Result<std::unique_ptr<Publisher>> Publisher::create(Bus& bus, std::int32_t ingests,
                                                     std::int64_t now) {
  std::unique_ptr<Publisher> publisher(new Publisher(bus));
  for (std::int32_t i = 0; i < ingests; ++i) {
    if (auto added = publisher->add(i, now); !added) return pass_on(added);
  }
  publisher->statuses_ =
      bus.subscribe<status_t>(kStatusChannel, [self = publisher.get()](const status_t& status) {
        if (status.service == "ingest" && status.ready != 0) self->ready_.push_back(status.index);
      });
  return publisher;
}

Publisher::~Publisher() { bus_.unsubscribe(statuses_); }

Status Publisher::add(std::int32_t index, std::int64_t now) {
  auto endpoint = Endpoint::create(EndpointClass::kIngest, index);
  if (!endpoint) return pass_on(endpoint);
  auto link = OutLink::create(bus_, *endpoint, unbounded());
  if (!link) return pass_on(link);
  auto& ingest = ingests_[index];
  ingest.link = std::move(*link);
  ingest.known_since = now;
  return {};
}

std::size_t Publisher::in_flight() const {
  std::size_t sum = homeless_.size();
  for (const auto& [index, ingest] : ingests_) sum += ingest.unacknowledged.size();
  return sum;
}

bool Publisher::has_room(std::int64_t now) const {
  if (!homeless_.empty() || in_flight() >= kMaxInFlight) return false;
  std::size_t bytes = 0;
  for (const auto& [index, ingest] : ingests_) bytes += ingest.link->producer().held_bytes();
  return bytes < kMostBytes && std::ranges::any_of(ingests_, [now](const auto& entry) {
           return entry.second.is_there(now);
         });
}

/// Of equals the one whose turn was longest ago: where the first of them could keep up alone, an
/// ingest that joins would get nothing to do.
Publisher::Ingest* Publisher::least_loaded(std::int64_t now) {
  const auto load = [](const Ingest& ingest) {
    return std::pair(ingest.unacknowledged.size(), ingest.last_turn);
  };
  Ingest* best = nullptr;
  for (auto& [index, ingest] : ingests_) {
    if (!ingest.is_there(now)) continue;
    if (best == nullptr || load(ingest) < load(*best)) best = &ingest;
  }
  return best;
}

void Publisher::give(Ingest& ingest, Homeless scan) {
  ingest.last_turn = ++turns_;
  ingest.unacknowledged.push_back(
      {ingest.link->producer().offer(MessageKind::kScan, std::move(scan.scan)), scan.seq,
       scan.published_at});
}

void Publisher::publish(const scan_t& scan, std::int64_t now) {
  VOX_CHECK(has_room(now));
  give(*least_loaded(now), {scan.seq, now, encode_message(scan)});
  next_seq_ = scan.seq + 1;
}

Status Publisher::note_ready(std::int64_t now) {
  for (const auto index : std::exchange(ready_, {})) {
    if (!ingests_.contains(index)) {
      if (auto added = add(index, now); !added) {
        log_warning("ingest {} cannot be used: {}", index, added.error().message);
        continue;
      }
    }
    ingests_[index].ready_at = now;
  }
  return {};
}

/// A fresh stream in place of the old one: should the ingest come back, it need not do again what
/// others do by then.
Status Publisher::leave_the_gone(std::int64_t now) {
  if (least_loaded(now) == nullptr) return {};
  for (auto& [index, ingest] : ingests_) {
    if (ingest.unacknowledged.empty() || ingest.is_there(now)) continue;
    log_warning("ingest {} is gone; the {} scans it had go to others", index,
                ingest.unacknowledged.size());
    moved_ += ingest.unacknowledged.size();
    resent_by_gone_ += ingest.link->producer().counters().chunks_resent;
    auto scans = ingest.link->producer().uncommitted();
    VOX_CHECK(scans.size() == ingest.unacknowledged.size());
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const InFlight& scan = ingest.unacknowledged[i];
      homeless_.push_back({scan.seq, scan.published_at, std::move(scans[i])});
    }
    ingest.unacknowledged.clear();
    if (auto added = add(index, 0); !added) return added;
  }
  return {};
}

void Publisher::settle_homeless(std::int64_t now) {
  for (Ingest* ingest = least_loaded(now); ingest != nullptr && !homeless_.empty();
       ingest = least_loaded(now)) {
    give(*ingest, std::move(homeless_.front()));
    homeless_.pop_front();
  }
}

Status Publisher::pump(std::int64_t now) {
  if (auto noted = note_ready(now); !noted) return noted;
  for (auto& [index, ingest] : ingests_) {
    if (auto pumped = ingest.link->pump(now); !pumped) return pumped;
    const auto committed = ingest.link->producer().committed_messages();
    while (!ingest.unacknowledged.empty() && ingest.unacknowledged.front().number < committed) {
      const std::int64_t took = now - ingest.unacknowledged.front().published_at;
      delay_ = {delay_.sum + took, std::max(delay_.most, took)};
      ingest.unacknowledged.pop_front();
      ++durable_;
    }
  }
  if (auto left = leave_the_gone(now); !left) return left;
  settle_homeless(now);
  return {};
}

std::int64_t Publisher::next_poll(std::int64_t now) const {
  std::int64_t next = INT64_MAX;
  for (const auto& [index, ingest] : ingests_) {
    next = std::min(next, ingest.link->producer().next_poll(now));
  }
  return next;
}

std::int64_t Publisher::durable_below() const {
  auto below = next_seq_;
  for (const auto& scan : homeless_) below = std::min(below, scan.seq);
  for (const auto& [index, ingest] : ingests_) {
    for (const auto& scan : ingest.unacknowledged) below = std::min(below, scan.seq);
  }
  return below;
}

std::int64_t Publisher::last_heard() const {
  std::int64_t last = 0;
  for (const auto& [index, ingest] : ingests_) last = std::max(last, ingest.last_heard());
  return last;
}

std::uint64_t Publisher::chunks_resent() const {
  std::uint64_t sum = resent_by_gone_;
  for (const auto& [index, ingest] : ingests_) {
    sum += ingest.link->producer().counters().chunks_resent;
  }
  return sum;
}

}  // namespace voxatlas
