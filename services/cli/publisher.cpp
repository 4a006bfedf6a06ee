#include "cli/publisher.hpp"

#include <algorithm>
#include <numeric>

#include "base/check.hpp"

namespace voxatlas {

Result<std::unique_ptr<Publisher>> Publisher::create(Bus& bus, std::int32_t ingests) {
  auto publisher = std::make_unique<Publisher>();
  for (std::int32_t i = 0; i < ingests; ++i) {
    auto endpoint = Endpoint::create(EndpointClass::kIngest, i);
    if (!endpoint) return pass_on(endpoint);
    auto link = OutLink::create(bus, *endpoint, StreamConfig{});
    if (!link) return pass_on(link);
    publisher->ingests_.push_back({std::move(*link), {}});
  }
  return publisher;
}

std::size_t Publisher::in_flight() const {
  return std::accumulate(
      ingests_.begin(), ingests_.end(), std::size_t{0},
      [](std::size_t sum, const Ingest& ingest) { return sum + ingest.unacknowledged.size(); });
}

bool Publisher::has_room() const {
  return in_flight() < kMaxInFlight && std::ranges::any_of(ingests_, [](const Ingest& ingest) {
           return ingest.link->producer().has_room();
         });
}

Publisher::Ingest& Publisher::least_loaded() {
  Ingest* best = nullptr;
  for (auto& ingest : ingests_) {
    if (!ingest.link->producer().has_room()) continue;
    if (best == nullptr || ingest.unacknowledged.size() < best->unacknowledged.size()) {
      best = &ingest;
    }
  }
  VOX_CHECK(best != nullptr);
  return *best;
}

void Publisher::publish(const scan_t& scan) {
  VOX_CHECK(has_room());
  Ingest& ingest = least_loaded();
  ingest.unacknowledged.push_back(
      ingest.link->producer().offer(MessageKind::kScan, encode_message(scan)));
}

Status Publisher::pump(std::int64_t now) {
  for (auto& ingest : ingests_) {
    if (auto pumped = ingest.link->pump(now); !pumped) return pumped;
    const auto committed = ingest.link->producer().committed_messages();
    while (!ingest.unacknowledged.empty() && ingest.unacknowledged.front() < committed) {
      ingest.unacknowledged.pop_front();
      ++durable_;
    }
  }
  return {};
}

std::int64_t Publisher::next_poll(std::int64_t now) const {
  std::int64_t next = INT64_MAX;
  for (const auto& ingest : ingests_) {
    next = std::min(next, ingest.link->producer().next_poll(now));
  }
  return next;
}

std::int64_t Publisher::last_heard() const {
  std::int64_t last = 0;
  for (const auto& ingest : ingests_) last = std::max(last, ingest.link->producer().last_heard());
  return last;
}

std::uint64_t Publisher::chunks_resent() const {
  std::uint64_t sum = 0;
  for (const auto& ingest : ingests_) sum += ingest.link->producer().counters().chunks_resent;
  return sum;
}

}  // namespace voxatlas
