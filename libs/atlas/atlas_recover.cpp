// What an atlas knows is what the store knows: tiles, then the journal redone over them.
#include <fmt/format.h>

#include "atlas/atlas_state.hpp"

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
  stale = true;  // Until the end is reached.
  cache.clear();
  journal = {};
  marks.clear();
  unreported.clear();
  rested = {};
  rest_cursor = TileKey::from_morton(0).value();
  auto stored = store.marks(shard);
  if (!stored) return pass_on(stored);
  for (const auto& mark : *stored) marks[{mark.source, mark.session}] = mark.seq;
  auto replayed = store.replay(
      shard, [this](JournalPosition position, ByteView bytes) { return redo(position, bytes); });
  if (!replayed) return replayed;
  stale = false;
  return {};
}

Status Atlas::State::redo(JournalPosition position, ByteView bytes) {
  auto record = decode_record(bytes);
  if (!record) return pass_on(record, fmt::format("shard {}, position {}", shard, position));
  journal.append(position, bytes.size());
  auto& mark = marks.try_emplace({record->source, record->session}, -1).first->second;
  mark = std::max(mark, record->seq);  // Marks are stored as of the trim: later than old records.
  for (const auto& delta : record->deltas) {
    if (auto ok = redo_delta(position, delta); !ok) return ok;
  }
  return {};
}

/// Applied where the tile's version is one less, skipped where it is as high.
Status Atlas::State::redo_delta(JournalPosition position, const JournalDelta& delta) {
  auto tile = load(delta.key);
  if (!tile) return pass_on(tile);
  const std::uint64_t version = *tile == nullptr ? 0 : (*tile)->version;
  if (position > reported) {
    unreported.push_back({delta.key, delta.version, Bytes(delta.delta.begin(), delta.delta.end())});
  }
  if (delta.version <= version) return {};
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
  return keep_budget(delta.key);
}

std::vector<Mark> Atlas::State::mark_list() const {
  std::vector<Mark> list;
  for (const auto& [session, seq] : marks) list.push_back({session.first, session.second, seq});
  return list;
}

}  // namespace voxatlas
