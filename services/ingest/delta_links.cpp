#include "ingest/delta_links.hpp"

#include <algorithm>

namespace voxatlas {

Result<std::unique_ptr<DeltaLinks>> DeltaLinks::create(Bus& bus, std::int32_t shards) {
  auto links = std::make_unique<DeltaLinks>();
  for (std::int32_t shard = 0; shard < shards; ++shard) {
    auto endpoint = Endpoint::create(EndpointClass::kStore, shard);
    if (!endpoint) return pass_on(endpoint);
    auto link = OutLink::create(bus, *endpoint, StreamConfig{});
    if (!link) return pass_on(link);
    links->shards_.push_back({std::move(*link), {}, {}});
  }
  return links;
}

void DeltaLinks::send(IngestService::Outgoing outgoing) {
  for (std::size_t i = 0; i < shards_.size(); ++i) {
    shards_[i].waiting.emplace_back(outgoing.scan, encode_message(outgoing.shards[i]));
  }
}

Status DeltaLinks::pump(IngestService& service, std::int64_t now) {
  for (std::size_t i = 0; i < shards_.size(); ++i) {
    auto& [link, waiting, unacked] = shards_[i];
    auto& producer = link->producer();
    while (!waiting.empty() && producer.has_room()) {
      auto& [scan, message] = waiting.front();
      unacked.emplace_back(producer.offer(MessageKind::kScanDelta, std::move(message)), scan);
      waiting.pop_front();
    }
    if (auto pumped = link->pump(now); !pumped) return pumped;
    while (!unacked.empty() && unacked.front().first < producer.committed_messages()) {
      service.committed(unacked.front().second, static_cast<std::int32_t>(i));
      unacked.pop_front();
    }
  }
  return {};
}

std::int64_t DeltaLinks::next_poll(std::int64_t now) {
  std::int64_t next = INT64_MAX;
  for (auto& shard : shards_) next = std::min(next, shard.link->producer().next_poll(now));
  return next;
}

bool DeltaLinks::has_room() const {
  return std::all_of(shards_.begin(), shards_.end(),
                     [](const Shard& shard) { return shard.waiting.empty(); });
}

std::size_t DeltaLinks::held_bytes() {
  std::size_t bytes = 0;
  for (auto& shard : shards_) {
    bytes += shard.link->producer().held_bytes();
    for (const auto& [scan, message] : shard.waiting) bytes += message.size();
  }
  return bytes;
}

StreamProducer::Counters DeltaLinks::counters() {
  StreamProducer::Counters sum;
  for (auto& shard : shards_) {
    const auto& one = shard.link->producer().counters();
    sum.chunks_sent += one.chunks_sent;
    sum.chunks_resent += one.chunks_resent;
    sum.probes += one.probes;
    sum.acks += one.acks;
    sum.consumer_restarts += one.consumer_restarts;
  }
  return sum;
}

}  // namespace voxatlas
