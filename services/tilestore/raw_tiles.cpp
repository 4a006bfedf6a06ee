#include "tilestore/raw_tiles.hpp"

#include <algorithm>
#include <utility>

#include "base/utime.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kLookEvery = 50'000;

}  // namespace

Result<std::unique_ptr<RawTiles>> RawTiles::create(Bus& bus, std::int32_t compressors) {
  std::vector<std::unique_ptr<OutLink>> links;
  for (std::int32_t i = 0; i < compressors; ++i) {
    auto endpoint = Endpoint::create(EndpointClass::kCompress, i);
    if (!endpoint) return pass_on(endpoint);
    auto link = OutLink::create(bus, *endpoint, StreamConfig{});
    if (!link) return pass_on(link);
    links.push_back(std::move(*link));
  }
  return std::unique_ptr<RawTiles>(new RawTiles(std::move(links)));
}

Status RawTiles::pump(Atlas& atlas, std::int64_t now, bool idle) {
  if (!links_.empty() && now >= next_look_) {
    next_look_ = now + kLookEvery;
    if (auto handed = idle ? hand_out(atlas, now) : Status{}; !handed) return handed;
  }
  for (auto& link : links_) {
    if (auto pumped = link->pump(now); !pumped) return pumped;
  }
  return {};
}

std::vector<Handout::Seen> RawTiles::look() {
  std::vector<Handout::Seen> seen;
  for (const auto& link : links_) {
    const auto& producer = link->producer();
    seen.push_back({producer.has_room(), producer.held_bytes() > 0, producer.last_heard()});
  }
  return seen;
}

Status RawTiles::hand_out(Atlas& atlas, std::int64_t now) {
  handed_again_ += handout_.take_back(look(), now);
  if (handout_.is_full()) return {};
  for (const TileInfo& rested : atlas.rested(Handout::kMaxOut)) {
    if (handout_.has(rested.key)) continue;
    const auto to = handout_.whom(look(), now);
    if (!to) break;
    if (auto given = give(atlas, rested.key, *to, now); !given) return given;
  }
  return {};
}

Status RawTiles::give(Atlas& atlas, TileKey tile, std::size_t to, std::int64_t now) {
  auto encoded = atlas.encoded(tile);
  if (!encoded) return pass_on(encoded);
  const auto& sensor = atlas.parameters().sensor;
  tile_raw_t raw{};
  raw.utime = utime_now();
  raw.tile = static_cast<std::int64_t>(encoded->key.morton());
  raw.version = static_cast<std::int64_t>(encoded->version);
  raw.shard = static_cast<std::int32_t>(atlas.shard());
  raw.clamp_min = sensor.clamp_min;
  raw.clamp_max = sensor.clamp_max;
  raw.payload = std::move(encoded->bytes);
  raw.size = static_cast<std::int32_t>(raw.payload.size());
  links_[to]->producer().offer(MessageKind::kTileRaw, encode_message(raw));
  handout_.given(tile, to, now);
  ++handed_out_;
  return {};
}

void RawTiles::add_to(StatusCounters& counters) const {
  counters.emplace_back("handed_to_compress", static_cast<double>(handed_out_));
  counters.emplace_back("handed_again", static_cast<double>(handed_again_));
  counters.emplace_back("out_to_compress", static_cast<double>(handout_.out()));
  std::vector<StreamProducer*> producers;
  for (const auto& link : links_) producers.push_back(&link->producer());
  add_outgoing(producers, counters);
}

std::int64_t RawTiles::next_poll(std::int64_t now) {
  std::int64_t next = links_.empty() ? INT64_MAX : next_look_;
  for (auto& link : links_) next = std::min(next, link->producer().next_poll(now));
  return next;
}

}  // namespace voxatlas
