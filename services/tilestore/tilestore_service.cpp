#include "tilestore/tilestore_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/bus.hpp"

namespace voxatlas {

/// What tile_update_t's payload is.
static constexpr std::int8_t kDeltaContent = 1, kTileContent = 2;

TilestoreService::TilestoreService(Atlas& atlas, std::size_t commit_bytes)
    : atlas_(atlas),
      pace_(std::min(commit_bytes, kMaxCommitBytes)),
      parameters_id_(parameters_id(atlas.parameters())) {
  const auto marks = atlas.marks();
  order_.start_from(marks);
  for (const auto& mark : marks) marks_.note(mark.source, mark.session, mark.seq);
}

bool TilestoreService::has_room() const { return ready_bytes_ < pace_.bytes(); }

void TilestoreService::take(const scan_delta_t& message, std::int64_t session,
                            std::int64_t number) {
  ++counters_.deltas;
  auto scan = to_shard_scan(message);
  Result<ScanOrder::Offer> offered = ScanOrder::Offer::kTaken;
  if (scan) offered = order_.offer(std::move(*scan), message.acked_below);
  if (!scan || !offered) {
    ++counters_.refused;
    log_error("delta of scan {} of {}, session {}, refused: {}", message.seq, message.source,
              message.session, scan ? offered.error().message : scan.error().message);
  } else if (*offered == ScanOrder::Offer::kDuplicate) {
    ++counters_.duplicates;
  }
  const bool usable = scan && offered;
  streams_[session].push_back({number, message.source, message.session,
                               usable ? message.seq : INT64_MAX});  // Never at or below a mark.
  for (auto& ready : order_.take_ready()) {
    for (const auto& [key, delta] : ready.deltas) ready_bytes_ += delta.size();
    ready_.push_back(std::move(ready));
  }
}

Result<ShardScan> TilestoreService::to_shard_scan(const scan_delta_t& message) const {
  const auto& parameters = atlas_.parameters();
  if (message.shard != static_cast<std::int32_t>(atlas_.shard()) ||
      message.shards != static_cast<std::int32_t>(parameters.shards)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("for shard {} of {}, this is {} of {}", message.shard, message.shards,
                            atlas_.shard(), parameters.shards));
  }
  if (message.parameters != parameters_id_) {
    return fail(ErrorCode::kInvalid, "it was computed with other model parameters");
  }
  ShardScan scan{message.source, message.session, message.seq, {}};
  ByteReader reader(message.data);
  for (std::int32_t i = 0; i < message.tiles && reader.ok(); ++i) {
    auto key = TileKey::from_morton(reader.get<std::uint64_t>());
    if (!key) return pass_on(key);
    const ByteView delta = reader.get_bytes(reader.get<std::uint32_t>());
    scan.deltas.emplace_back(*key, Bytes(delta.begin(), delta.end()));
  }
  if (!reader.at_end()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} tiles do not fit {} bytes", message.tiles, message.data.size()));
  }
  if (auto sound = atlas_.check_scan(scan); !sound) return pass_on(sound);
  return scan;
}

Result<std::vector<TilestoreService::Acknowledgement>> TilestoreService::commit(
    const Publish& publish) {
  if (!ready_.empty()) {
    std::int64_t durable = 0, began = 0;  // All of them since before the first was told of.
    auto committed = atlas_.commit(ready_, [&](const TileChange& change) {
      if (durable == 0) {
        durable = utime_now();
        began = steady_utime();
      }
      publish(to_update(change.key, change.version, durable, kDeltaContent, change.delta));
    });
    if (!committed) return pass_on(committed);
    if (durable > 0) pace_.applied(ready_bytes_, steady_utime() - began);
    ++counters_.commits;
    for (const auto& scan : ready_) marks_.note(scan.source, scan.session, scan.seq);
    ready_.clear();
    ready_bytes_ = 0;
  }
  return acknowledge();
}

std::vector<TilestoreService::Acknowledgement> TilestoreService::acknowledge() {
  std::vector<Acknowledgement> result;
  for (auto& [stream, messages] : streams_) {
    Acknowledgement last;
    while (!messages.empty() &&
           messages.front().seq <= atlas_.mark(messages.front().source, messages.front().session)) {
      last = {stream, messages.front().number};
      messages.pop_front();
    }
    if (last.session != 0) result.push_back(last);
  }
  std::erase_if(streams_, [](const auto& entry) { return entry.second.empty(); });
  return result;
}

tile_update_t TilestoreService::to_update(TileKey key, std::uint64_t version, std::int64_t durable,
                                          std::int8_t content, const Bytes& payload) const {
  tile_update_t update{};
  update.utime = durable;
  update.tile = static_cast<std::int64_t>(key.morton());
  update.version = static_cast<std::int64_t>(version);
  update.shard = static_cast<std::int32_t>(atlas_.shard());
  if (payload.size() + 64 <= Bus::kMaxPlainBytes) {
    update.content = content;
    update.payload = payload;
    update.size = static_cast<std::int32_t>(update.payload.size());
  }
  return update;
}

std::optional<tile_update_t> TilestoreService::take(const tile_encoded_t& message) {
  const auto version = static_cast<std::uint64_t>(message.version);
  auto key = atlas_.parameters().grid().tile_from_morton(static_cast<std::uint64_t>(message.tile));
  Result<std::optional<std::uint64_t>> taken = std::nullopt;
  if (key) {
    taken = atlas_.take_encoded({*key, version, message.payload});
  } else {
    taken = pass_on(key);
  }
  if (!taken) {
    ++counters_.encoded_wrong;
    log_warning("compressed tile {:#x} refused: {}", static_cast<std::uint64_t>(message.tile),
                taken.error().message);
    return std::nullopt;
  }
  ++(*taken ? counters_.encoded_taken : counters_.encoded_stale);
  if (!*taken || **taken == version) return std::nullopt;
  ++counters_.encoded_lossy;
  return to_update(*key, **taken, utime_now(), kTileContent, message.payload);
}

}  // namespace voxatlas
