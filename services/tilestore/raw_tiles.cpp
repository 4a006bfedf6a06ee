#include "tilestore/raw_tiles.hpp"

#include <algorithm>

#include "base/utime.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kLookEvery = 200'000;

}  // namespace

Result<std::unique_ptr<RawTiles>> RawTiles::create(Bus& bus, std::int32_t compressors) {
  auto raw = std::make_unique<RawTiles>();
  for (std::int32_t i = 0; i < compressors; ++i) {
    auto endpoint = Endpoint::create(EndpointClass::kCompress, i);
    if (!endpoint) return pass_on(endpoint);
    auto link = OutLink::create(bus, *endpoint, StreamConfig{});
    if (!link) return pass_on(link);
    raw->links_.push_back(std::move(*link));
  }
  return raw;
}

Status RawTiles::pump(Atlas& atlas, std::int64_t now) {
  if (!links_.empty() && now >= next_look_) {
    next_look_ = now + kLookEvery;
    if (auto handed = hand_out(atlas, now); !handed) return handed;
  }
  for (auto& link : links_) {
    if (auto pumped = link->pump(now); !pumped) return pumped;
  }
  return {};
}

Status RawTiles::hand_out(Atlas& atlas, std::int64_t now) {
  std::erase_if(out_, [&](const auto& entry) { return now - entry.second > kPatience; });
  if (out_.size() >= kMaxOut) return {};
  for (const TileInfo& rested : atlas.rested(kMaxOut)) {
    if (out_.size() >= kMaxOut) break;
    if (out_.contains(rested.key)) continue;
    OutLink& link = *links_[turn_++ % links_.size()];
    if (!link.producer().has_room()) continue;
    auto encoded = atlas.encoded(rested.key);
    if (!encoded) return pass_on(encoded);
    tile_raw_t raw{};
    raw.utime = utime_now();
    raw.tile = static_cast<std::int64_t>(encoded->key.morton());
    raw.version = static_cast<std::int64_t>(encoded->version);
    raw.shard = static_cast<std::int32_t>(atlas.shard());
    raw.payload = std::move(encoded->bytes);
    raw.size = static_cast<std::int32_t>(raw.payload.size());
    link.producer().offer(MessageKind::kTileRaw, encode_message(raw));
    out_.emplace(rested.key, now);
    ++handed_out_;
  }
  return {};
}

std::int64_t RawTiles::next_poll(std::int64_t now) {
  std::int64_t next = links_.empty() ? INT64_MAX : next_look_;
  for (auto& link : links_) next = std::min(next, link->producer().next_poll(now));
  return next;
}

}  // namespace voxatlas
