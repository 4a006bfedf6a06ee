#include "ingest/delta_links.hpp"

#include <algorithm>
#include <limits>

namespace voxatlas {

Result<std::unique_ptr<DeltaLinks>> DeltaLinks::create(Bus& bus, std::int32_t shards) {
  auto links = std::make_unique<DeltaLinks>();
  StreamConfig config;
  config.send_buffer_bytes = std::numeric_limits<std::size_t>::max();
  for (std::int32_t shard = 0; shard < shards; ++shard) {
    auto endpoint = Endpoint::create(EndpointClass::kStore, shard);
    if (!endpoint) return pass_on(endpoint);
    auto link = OutLink::create(bus, *endpoint, config);
    if (!link) return pass_on(link);
    links->shards_.push_back({std::move(*link), {}});
  }
  return links;
}

void DeltaLinks::send(const IngestService::Outgoing& outgoing) {
  for (std::size_t i = 0; i < shards_.size(); ++i) {
    auto& [link, unacked] = shards_[i];
    unacked.emplace_back(
        link->producer().offer(MessageKind::kScanDelta, encode_message(outgoing.shards[i])),
        outgoing.scan);
  }
}

Status DeltaLinks::pump(IngestService& service, std::int64_t now) {
  for (std::size_t i = 0; i < shards_.size(); ++i) {
    auto& [link, unacked] = shards_[i];
    auto& producer = link->producer();
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

std::size_t DeltaLinks::held_bytes() const {
  std::size_t bytes = 0;
  for (const auto& shard : shards_) bytes += shard.link->producer().held_bytes();
  return bytes;
}

std::vector<StreamProducer*> DeltaLinks::producers() {
  std::vector<StreamProducer*> result;
  for (auto& shard : shards_) result.push_back(&shard.link->producer());
  return result;
}

}  // namespace voxatlas
