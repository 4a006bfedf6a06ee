#include "ingest/plain_scans.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/crc32c.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {

namespace {

constexpr const char* kSuffix = "~plain";
/// Loggers hash sources too when they want to know who takes them: CRC-32C, mixed.
std::uint64_t hash_of(const std::string& source) { return splitmix64(crc32c(as_bytes(source))); }

/// All fields that must be alike in every part of a scan.
bool same_scan(const scan_t& a, const scan_t& b) {
  return a.utime == b.utime && a.parts == b.parts && a.sigma == b.sigma &&
         a.min_range == b.min_range && a.coloured == b.coloured &&
         std::equal(a.ecef_from_sensor, a.ecef_from_sensor + 12, b.ecef_from_sensor);
}

}  // namespace

PlainScans::PlainScans(std::int32_t ingest, std::int32_t ingests, std::int64_t session)
    : ingest_(ingest), ingests_(ingests), session_(session) {}

bool PlainScans::is_ours(const std::string& source) const {
  return hash_of(source) % static_cast<std::uint64_t>(ingests_) ==
         static_cast<std::uint64_t>(ingest_);
}

Status PlainScans::check(const scan_t& part, const ScanIdentity& identity) const {
  if (part.parts < 1 || part.parts > kMaxParts || part.part < 0 || part.part >= part.parts) {
    return fail(ErrorCode::kOutOfRange, fmt::format("scan {} of {}: part {} of {}", part.seq,
                                                    part.source, part.part, part.parts));
  }
  if (seen_.size() >= kMaxSources && !seen_.contains({identity.source, identity.session})) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("scan of {}: more than {} plain sources and sessions", part.source,
                            kMaxSources));
  }
  return {};
}

Result<std::optional<scan_t>> PlainScans::offer(const scan_t& part, std::int64_t now) {
  auto identity = identity_of(part);
  if (!identity) return pass_on(identity);
  if (auto sound = check(part, *identity); !sound) return pass_on(sound);
  ++counters_.parts;
  expire(now);
  if (was_whole(*identity)) {
    ++counters_.repeated;
    return std::nullopt;
  }
  Open& open = open_for(*identity, part.parts, now);
  for (const auto& known : open.parts) {
    if (known && !same_scan(*known, part)) {
      return fail(ErrorCode::kCorrupt, fmt::format("scan {} of {}: part {} contradicts part {}",
                                                   part.seq, part.source, part.part, known->part));
    }
  }
  auto& slot = open.parts[static_cast<std::size_t>(part.part)];
  if (!slot) --open.missing;
  slot = part;
  if (open.missing > 0) return std::nullopt;
  note_whole(*identity);
  ++counters_.whole;
  scan_t whole = join(open);
  open_.erase(*identity);
  return whole;
}

PlainScans::Open& PlainScans::open_for(const ScanIdentity& identity, std::int16_t parts,
                                       std::int64_t now) {
  if (const auto known = open_.find(identity); known != open_.end()) return known->second;
  if (open_.size() >= kMaxOpen) {
    ++counters_.incomplete;
    open_.erase(std::min_element(open_.begin(), open_.end(), [](const auto& a, const auto& b) {
      return a.second.since < b.second.since;
    }));
  }
  Open& fresh = open_[identity];
  fresh.since = now;
  fresh.parts.resize(static_cast<std::size_t>(parts));
  fresh.missing = fresh.parts.size();
  return fresh;
}

void PlainScans::expire(std::int64_t now) {
  counters_.incomplete +=
      std::erase_if(open_, [&](const auto& entry) { return now - entry.second.since > kPatience; });
}

bool PlainScans::was_whole(const ScanIdentity& identity) const {
  const auto seen = seen_.find({identity.source, identity.session});
  if (seen == seen_.end() || identity.seq > seen->second.newest) return false;
  const std::int64_t age = seen->second.newest - identity.seq;
  return age >= 64 || (seen->second.whole >> age & 1) != 0;
}

void PlainScans::note_whole(const ScanIdentity& identity) {
  Seen& seen = seen_[{identity.source, identity.session}];
  const std::int64_t ahead = identity.seq - seen.newest;
  if (ahead > 0) {
    counters_.gaps += static_cast<std::uint64_t>(ahead - 1);
    seen.whole = ahead >= 64 ? 1 : seen.whole << ahead | 1;
    seen.newest = identity.seq;
  } else {
    --counters_.gaps;  // It was counted missing and came after all.
    seen.whole |= std::uint64_t{1} << -ahead;
  }
}

scan_t PlainScans::join(const Open& open) {
  constexpr std::size_t kPointBytes = 12;
  scan_t whole = *open.parts.front();
  whole.points.clear();
  whole.count = 0;
  for (const auto& part : open.parts) {  // All coordinates, then all colours.
    whole.points.insert(whole.points.end(), part->points.begin(),
                        part->points.begin() + part->count * std::ptrdiff_t{kPointBytes});
    whole.count += part->count;
  }
  for (const auto& part : open.parts) {
    whole.points.insert(whole.points.end(),
                        part->points.begin() + part->count * std::ptrdiff_t{kPointBytes},
                        part->points.end());
  }
  whole.size = static_cast<std::int32_t>(whole.points.size());
  whole.part = 0;
  whole.parts = 1;
  return whole;
}

void PlainScans::adopt(scan_t& whole) {
  const std::string_view suffix = kSuffix;
  whole.source = whole.source.substr(0, ScanIdentity::kMaxSourceBytes - suffix.size());
  whole.source += suffix;
  whole.session = session_;
  whole.seq = next_seq_[whole.source]++;
}

}  // namespace voxatlas
