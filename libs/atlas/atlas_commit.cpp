// Scans in: checked, appended to the journal as one, applied in memory.
#include <fmt/format.h>

#include <algorithm>

#include "atlas/atlas_state.hpp"
#include "base/log.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {

static std::string name_of_scan(const ShardScan& scan) {
  return fmt::format("scan {} of source \"{}\", session {}", scan.seq, scan.source, scan.session);
}

/// Not this commit's error: it is durable. The next one is refused while it lasts (make_room).
static void say_behind(const Error& error) {
  log_warning("tiles cannot be written behind: {}", error.message);
}

std::int64_t Atlas::State::mark(const Session& session) const {
  const auto found = marks.find(session);
  return found == marks.end() ? -1 : found->second;
}

Status Atlas::State::check_place(const ShardScan& scan, TileKey key) const {
  if (auto on_grid = grid.tile_from_morton(key.morton()); !on_grid) {
    return pass_on(on_grid, name_of_scan(scan));
  }
  const auto owner = shard_of(key, parameters.shards);
  if (owner == shard) return {};
  return fail(ErrorCode::kOutOfRange, fmt::format("{}: tile {:#x} belongs to shard {}, not {}",
                                                  name_of_scan(scan), key.morton(), owner, shard));
}

Status Atlas::State::check_scan(const ShardScan& scan) const {
  const TileKey* before = nullptr;
  for (const auto& [key, bytes] : scan.deltas) {
    if (auto ok = check_place(scan, key); !ok) return pass_on(ok);
    if (before != nullptr && *before >= key) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{}: tile {:#x} comes after {:#x}", name_of_scan(scan), key.morton(),
                              before->morton()));
    }
    before = &key;
    if (auto delta = decode_delta(bytes); !delta) {
      return pass_on(delta, fmt::format("{}, tile {:#x}", name_of_scan(scan), key.morton()));
    }
  }
  return {};
}

Result<std::vector<const ShardScan*>> Atlas::State::fresh_scans(
    std::span<const ShardScan> scans) const {
  std::vector<const ShardScan*> fresh;
  Marks ahead;  // Where this very commit has got to.
  for (const auto& scan : scans) {
    const Session session{scan.source, scan.session};
    auto& last = ahead.try_emplace(session, mark(session)).first->second;
    if (scan.seq <= last) continue;
    if (scan.seq != last + 1) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: a gap, the last one applied is {}", name_of_scan(scan), last));
    }
    if (auto sound = check_scan(scan); !sound) return pass_on(sound);
    fresh.push_back(&scan);
    last = scan.seq;
  }
  return fresh;
}

/// Below the budgets before anything new is taken: while that fails nothing is, and nothing grows.
Status Atlas::State::make_room() {
  if (auto ok = keep_budget(std::nullopt); !ok) return ok;
  return keep_journal();
}

/// The version of every tile that these scans touch, 0 where never written. Of those that are not
/// in memory only the version is wanted: they are read for good when their turn comes, as a commit
/// may touch more tiles than there is room for.
Result<Atlas::State::Versions> Atlas::State::current_versions(
    const std::vector<const ShardScan*>& scans) {
  Versions versions;
  for (const auto* scan : scans) {
    for (const auto& [key, bytes] : scan->deltas) versions.emplace(key, 0);
  }
  constexpr std::size_t kReadAtOnce = 32;
  std::vector<TileKey> missing;
  for (auto& [key, version] : versions) {
    if (const auto* tile = cache.peek(key)) {
      version = tile->version;
    } else {
      missing.push_back(key);
    }
  }
  for (std::size_t at = 0; at < missing.size(); at += kReadAtOnce) {
    const auto count = std::min(kReadAtOnce, missing.size() - at);
    auto found = store.multi_get(shard, std::span(missing).subspan(at, count));
    if (!found) return pass_on(found);
    for (const auto& stored : *found) {
      if (stored) versions[stored->key] = stored->version;
    }
  }
  return versions;
}

/// One record a scan, all in one append. Returns the first one's position.
Result<JournalPosition> Atlas::State::append(const std::vector<const ShardScan*>& scans,
                                             Versions versions) {
  std::vector<Bytes> records;
  for (const auto* scan : scans) {
    JournalRecord record{scan->source, scan->session, scan->seq, {}};
    for (const auto& [key, bytes] : scan->deltas) {
      record.deltas.push_back({key, ++versions.at(key), bytes});
    }
    records.push_back(encode_record(record));
  }
  auto last = store.append(shard, epoch, records);
  if (!last) return pass_on(last);
  const JournalPosition first = *last - records.size() + 1;
  for (std::size_t i = 0; i < records.size(); ++i) journal.append(first + i, records[i].size());
  return first;
}

/// The records are durable: what cannot be applied now is applied by a recovery. A delta is decoded
/// when its tile's turn comes: all of a carving scan's at once are some 30 MB.
Status Atlas::State::apply(TileKey key, ByteView bytes, JournalPosition position) {
  auto delta = decode_delta(bytes);
  if (!delta) return pass_on(delta);  // check_scan has decoded it before.
  auto tile = load(key);
  if (!tile) return pass_on(tile);
  if (*tile == nullptr) *tile = &cache.insert(key, {}, 0);
  (*tile)->tree.apply(*delta, parameters.sensor);
  cache.changed(key, position);
  rested.remove(key);
  if (auto ok = keep_budget(key); !ok) say_behind(ok.error());
  ++counts.deltas_applied;
  return {};
}

/// Tile by tile, each with the deltas of all scans, so that it is read and written once where not
/// all of them fit into memory; and from the other end each time, as those that came last are still
/// there.
Status Atlas::State::apply_all(const std::vector<const ShardScan*>& scans, JournalPosition first,
                               Versions versions, const Tell& tell) {
  struct Step {
    TileKey key;
    JournalPosition position;
    ByteView delta;
  };
  std::vector<Step> steps;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (const auto& [key, bytes] : scans[i]->deltas) steps.push_back({key, first + i, bytes});
  }
  ascending = !ascending;
  std::ranges::sort(steps, [&](const Step& a, const Step& b) {
    if (a.key != b.key) return (a.key < b.key) == ascending;
    return a.position < b.position;
  });
  for (const auto& step : steps) {
    if (auto ok = apply(step.key, step.delta, step.position); !ok) return ok;
    report({step.key, ++versions.at(step.key), Bytes(step.delta.begin(), step.delta.end())}, tell);
  }
  for (const auto* scan : scans) marks[{scan->source, scan->session}] = scan->seq;
  counts.scans_applied += scans.size();
  return {};
}

void Atlas::State::report(const TileChange& change, const Tell& tell) {
  tell(change);
  told[change.key] = change.version;
}

/// All that is in the journal and was not told yet has been applied: by a recovery, or just now.
void Atlas::State::report_rest(const Tell& tell) {
  for (const auto& change : std::exchange(unreported, {})) tell(change);
  reported = std::max(reported, journal.last());
  told.clear();
}

/// After an append whose outcome is not known, or an apply that failed: asks the store. If it has
/// these scans, all is well; otherwise the error stands, and the next call asks again.
Status Atlas::State::read_back(const std::vector<const ShardScan*>& scans, Error error,
                               const Tell& tell) {
  stale = true;
  if (auto recovered = recover(); !recovered) {
    error.message += "; reading back: " + recovered.error().message;
    return tl::unexpected(std::move(error));
  }
  for (const auto* scan : scans) {
    if (mark({scan->source, scan->session}) < scan->seq) {
      return tl::unexpected(std::move(error));
    }
  }
  report_rest(tell);
  return {};
}

Status Atlas::State::commit(std::span<const ShardScan> scans, const Tell& tell) {
  if (auto ok = settle(); !ok) return pass_on(ok);
  auto fresh = fresh_scans(scans);
  if (!fresh) return pass_on(fresh);
  if (fresh->empty()) {
    report_rest(tell);
    return {};
  }
  if (auto ok = make_room(); !ok) return pass_on(ok);
  auto versions = current_versions(*fresh);
  if (!versions) return pass_on(versions);
  auto first = append(*fresh, *versions);
  if (!first) {
    const auto code = first.error().code;
    if (code != ErrorCode::kUnknown && code != ErrorCode::kIo) return pass_on(first);
    return read_back(*fresh, std::move(first.error()), tell);
  }
  for (const auto& change : std::exchange(unreported, {})) report(change, tell);
  if (auto applied = apply_all(*fresh, *first, std::move(*versions), tell); !applied) {
    return read_back(*fresh, std::move(applied.error()), tell);
  }
  report_rest(tell);
  if (auto ok = keep_journal(); !ok) say_behind(ok.error());
  return {};
}

}  // namespace voxatlas
