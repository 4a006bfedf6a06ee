#include "ingest/ingest_service.hpp"

#include <algorithm>

#include "base/check.hpp"
#include "base/log.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {

IngestService::IngestService(const ModelParameters& parameters, int workers)
    : parameters_(parameters),
      parameters_id_(parameters_id(parameters)),
      workers_(parameters.grid(), parameters.integration, workers) {}

void IngestService::take_message(MessageKind kind, ByteView payload, StreamRef from) {
  auto message = kind == MessageKind::kScan
                     ? decode_message<scan_t>(payload)
                     : Result<scan_t>(fail(ErrorCode::kCorrupt,
                                           fmt::format("message of kind {} instead of a scan",
                                                       static_cast<int>(kind))));
  if (message) return take(*message, from);
  ++counters_.unidentified;
  log_warning("dropped: {}", message.error().message);
  streams_[from.session].emplace_back(from.number, next_scan_++);
}

void IngestService::take(const scan_t& message, StreamRef from) {
  auto identity = identity_of(message);
  const std::uint64_t scan = next_scan_++;
  if (from.session != 0) streams_[from.session].emplace_back(from.number, scan);
  if (!identity) {
    ++counters_.unidentified;
    log_warning("dropped: {}", identity.error().message);
    return;
  }
  ++counters_.scans;
  InFlight entry{*identity, message.utime, from, std::vector<bool>(parameters_.shards, false),
                 parameters_.shards};
  in_flight_.emplace(scan, std::move(entry));
  ++integrating_;
  if (from.session == 0) ++plain_in_flight_;
  workers_.give(scan, message);
}

std::vector<IngestService::Outgoing> IngestService::finished() {
  std::vector<Outgoing> result;
  for (auto& done : workers_.take()) {
    --integrating_;
    const InFlight& scan = in_flight_.at(done.scan);
    if (!done.delta) {
      ++counters_.refused;
      log_warning("scan {} of {}, session {}, changes nothing: {}", scan.identity.seq,
                  scan.identity.source, scan.identity.session, done.delta.error().message);
      done.delta = ScanDelta{};
    }
    counters_.rays += done.delta->counts;
    result.push_back({done.scan, split(scan, *done.delta)});
  }
  return result;
}

std::vector<scan_delta_t> IngestService::split(const InFlight& scan, const ScanDelta& delta) const {
  std::vector<scan_delta_t> shards(parameters_.shards);
  for (std::size_t shard = 0; shard < shards.size(); ++shard) {
    auto& message = shards[shard];
    message.utime = scan.utime;
    message.source = scan.identity.source;
    message.session = scan.identity.session;
    message.seq = scan.identity.seq;
    message.acked_below = acked_below(scan.identity);
    message.parameters = parameters_id_;
    message.shard = static_cast<std::int32_t>(shard);
    message.shards = static_cast<std::int32_t>(shards.size());
    message.tiles = 0;
  }
  Bytes encoded;
  for (const auto& [tile, tile_delta] : delta.tiles) {
    auto& message = shards[shard_of(tile, parameters_.shards)];
    encoded.clear();
    encode_delta(tile_delta, encoded);
    ByteWriter writer(message.data);
    writer.put(tile.morton());
    writer.put(static_cast<std::uint32_t>(encoded.size()));
    writer.put_bytes(encoded);
    ++message.tiles;
  }
  for (auto& message : shards) message.size = static_cast<std::int32_t>(message.data.size());
  return shards;
}

void IngestService::committed(std::uint64_t scan, std::int32_t shard) {
  const auto at = in_flight_.find(scan);
  VOX_CHECK(at != in_flight_.end());
  auto& entry = at->second;
  VOX_CHECK(!entry.committed[static_cast<std::size_t>(shard)]);
  entry.committed[static_cast<std::size_t>(shard)] = true;
  if (--entry.waiting_for > 0) return;
  ++counters_.acknowledged;
  marks_.note(entry.identity.source, entry.identity.session, entry.identity.seq);
  // Other ingests may have this source's other scans, so only an unbroken run from 0 is known here.
  const auto known = acked_below_.find({entry.identity.source, entry.identity.session});
  if (entry.identity.seq == (known == acked_below_.end() ? 0 : known->second)) {
    acked_below_[{entry.identity.source, entry.identity.session}] = entry.identity.seq + 1;
  }
  if (entry.from.session == 0) --plain_in_flight_;
  in_flight_.erase(at);
}

std::int64_t IngestService::acked_below(const ScanIdentity& identity) const {
  const auto known = acked_below_.find({identity.source, identity.session});
  return known == acked_below_.end() ? 0 : known->second;
}

std::vector<StreamRef> IngestService::acknowledged() {
  std::vector<StreamRef> result;
  for (auto& [session, messages] : streams_) {
    StreamRef last{};
    while (!messages.empty() && !in_flight_.contains(messages.front().second)) {
      last = {session, messages.front().first};
      messages.pop_front();
    }
    if (last.session != 0) result.push_back(last);
  }
  std::erase_if(streams_, [](const auto& entry) { return entry.second.empty(); });
  return result;
}

}  // namespace voxatlas
