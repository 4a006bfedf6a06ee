// What an atlas knows is what the store knows: tiles, then the journal redone over them.
#include <fmt/format.h>

#include "atlas/atlas_state.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"

namespace voxatlas {

Status Atlas::State::acquire() {
  auto acquired = store.acquire(shard);
  if (!acquired) return pass_on(acquired, fmt::format("shard {}", shard));
  epoch = *acquired;
  return {};
}

Status Atlas::State::settle() {
  if (!stale) return {};
  return recover();
}

Status Atlas::State::recover() {
  const auto began = steady_utime();
  stale = true;  // Until the end is reached.
  cache.clear();
  journal = {};
  marks.clear();
  unreported.clear();
  counts.replayed_records = counts.replayed_bytes = 0;
  counts.redone_deltas = counts.skipped_deltas = 0;
  std::set<TileKey> redone_tiles;  // No more than the journal's bound allows.
  rested = {};
  rest_cursor = TileKey::from_morton(0).value();
  auto stored = store.marks(shard);
  if (!stored) return pass_on(stored);
  for (const auto& mark : *stored) marks[{mark.source, mark.session}] = mark.seq;
  auto replayed = store.replay(shard, [&](JournalPosition position, ByteView bytes) {
    return redo(position, bytes, redone_tiles);
  });
  if (!replayed) return replayed;
  stale = false;
  log_info(
      "shard {}: recovered in {} ms: {} journal records of {} bytes, {} deltas applied to {} "
      "tiles, "
      "{} were in their tiles already",
      shard, (steady_utime() - began) / 1000, counts.replayed_records, counts.replayed_bytes,
      counts.redone_deltas, redone_tiles.size(), counts.skipped_deltas);
  return {};
}

Status Atlas::State::redo(JournalPosition position, ByteView bytes,
                          std::set<TileKey>& redone_tiles) {
  auto record = decode_record(bytes);
  if (!record) return pass_on(record, fmt::format("shard {}, position {}", shard, position));
  journal.append(position, bytes.size());
  ++counts.replayed_records;
  counts.replayed_bytes += bytes.size();
  auto& mark = marks.try_emplace({record->source, record->session}, -1).first->second;
  mark = std::max(mark, record->seq);  // Marks are stored as of the trim: later than old records.
  for (const auto& delta : record->deltas) {
    auto applied = redo_delta(position, delta);
    if (!applied) return pass_on(applied);
    ++(*applied ? counts.redone_deltas : counts.skipped_deltas);
    if (*applied) redone_tiles.insert(delta.key);
  }
  return {};
}

/// Applied where the tile's version is one less, skipped where it is as high. Returns which.
Result<bool> Atlas::State::redo_delta(JournalPosition position, const JournalDelta& delta) {
  auto tile = load(delta.key);
  if (!tile) return pass_on(tile);
  const std::uint64_t version = *tile == nullptr ? 0 : (*tile)->version;
  const auto before = told.find(delta.key);
  if (position > reported && (before == told.end() || delta.version > before->second)) {
    unreported.push_back({delta.key, delta.version, Bytes(delta.delta.begin(), delta.delta.end())});
  }
  if (delta.version <= version) return false;
  if (delta.version != version + 1) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("shard {}: the journal's record {} makes version {} of tile {:#x}, of "
                            "which version {} is stored",
                            shard, position, delta.version, delta.key.morton(), version));
  }
  auto decoded = decode_delta(delta.delta);
  if (!decoded) return pass_on(decoded, fmt::format("shard {}, record {}", shard, position));
  if (*tile == nullptr) *tile = &cache.insert(delta.key, {}, 0);
  (*tile)->tree.apply(*decoded, parameters.sensor);
  cache.changed(delta.key, position);
  if (auto ok = keep_budget(delta.key); !ok) return pass_on(ok);
  return true;
}

std::vector<Mark> Atlas::State::mark_list() const {
  std::vector<Mark> list;
  for (const auto& [session, seq] : marks) list.push_back({session.first, session.second, seq});
  return list;
}

}  // namespace voxatlas
