// Tiles to the store, and the journal's end after them.
#include <fmt/format.h>

#include "atlas/atlas_state.hpp"
#include "base/log.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

/// One put holds at most so many tiles, and bytes but for the last.
static constexpr std::size_t kTilesAPut = 32;
static constexpr std::size_t kBytesAPut = std::size_t{1} << 20;

/// Writes the tiles whose oldest change is oldest, at most `max_tiles`.
Status Atlas::State::write_oldest(std::size_t max_tiles) {
  while (max_tiles > 0 && cache.dirty_tiles() > 0) {
    std::vector<StoredTile> batch;
    std::size_t bytes = 0;
    for (const auto key : cache.oldest_dirty(std::min(max_tiles, kTilesAPut))) {
      if (bytes >= kBytesAPut) break;
      auto* tile = cache.find(key);
      tile->tree.prune();
      batch.push_back({key, tile->version, encode_tile(tile->tree, {TileCodec::kFast})});
      bytes += batch.back().bytes.size();
    }
    if (auto ok = store.put(shard, epoch, batch); !ok) return ok;
    const auto now = RestedTiles::Clock::now();
    for (const auto& stored : batch) {
      cache.cleaned(stored.key);
      if (stored.bytes.size() >= options.rest_bytes) rested.add(stored.key, stored.version, now);
    }
    counts.tiles_flushed += batch.size();
    max_tiles -= batch.size();
  }
  return {};
}

/// Forgets the records behind the oldest unflushed change, and none whose changes nobody was told.
Status Atlas::State::trim() {
  const auto oldest = cache.oldest_change();
  const auto position = std::min(oldest ? *oldest - 1 : journal.last(), reported);
  if (!journal.holds(position)) return {};
  if (options.keep_journal) {  // Counted as trimmed all the same: nothing waits for them.
    journal.trim(position);
    return {};
  }
  if (auto ok = store.trim(shard, epoch, position, mark_list()); !ok) return ok;
  journal.trim(position);
  return {};
}

/// Drops clean tiles, and writes dirty ones where that is not enough. `keep` stays.
Status Atlas::State::keep_budget(std::optional<TileKey> keep) {
  while (!cache.evict(options.cache_bytes, keep) && cache.dirty_tiles() > 0) {
    if (auto ok = write_oldest(kTilesAPut); !ok) return ok;
  }
  return {};
}

Status Atlas::State::keep_journal() {
  while (journal.bytes() > options.journal_max_bytes) {
    const bool clean = cache.dirty_tiles() == 0;
    if (auto ok = write_oldest(kTilesAPut); !ok) return ok;
    if (auto ok = trim(); !ok) return ok;
    if (clean) break;  // What is left waits to be reported by this commit.
  }
  return {};
}

Result<std::optional<std::uint64_t>> Atlas::State::take_encoded(const EncodedTile& encoded) {
  auto decoded = decode_tile(encoded.bytes);
  if (!decoded) {
    rested.remove(encoded.key);  // Whoever made this of it would make it again.
    return pass_on(decoded, fmt::format("tile {:#x}", encoded.key.morton()));
  }
  auto tile = load(encoded.key);
  if (!tile) return pass_on(tile);
  if (*tile == nullptr || (*tile)->version != encoded.version) return std::nullopt;
  if ((*tile)->tree != *decoded) {
    rested.remove(encoded.key);
    if (codec_of(encoded.bytes).value() != TileCodec::kLossy) return std::nullopt;
    if (auto ok = put_lossy(encoded, **tile, std::move(*decoded)); !ok) return pass_on(ok);
    return encoded.version + 1;
  }
  const StoredTile stored[] = {{encoded.key, encoded.version, encoded.bytes}};
  if (auto ok = store.put(shard, epoch, stored); !ok) return pass_on(ok);
  cache.cleaned(encoded.key);
  rested.remove(encoded.key);
  return encoded.version;
}

/// A version of its own. It needs no journal record: the put is durable, and a recovery skips the
/// records that led to the version before.
Status Atlas::State::put_lossy(const EncodedTile& encoded, CachedTile& tile, TileTree&& tree) {
  if (!same_occupancy(tile.tree, tree)) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile {:#x}, lossy: voxels change between unknown, free and occupied",
                            encoded.key.morton()));
  }
  const StoredTile stored[] = {{encoded.key, encoded.version + 1, encoded.bytes}};
  if (auto ok = store.put(shard, epoch, stored); !ok) {
    const auto code = ok.error().code;
    stale = code == ErrorCode::kUnknown || code == ErrorCode::kIo;  // Which version is it now?
    return ok;
  }
  tile.tree = std::move(tree);
  ++tile.version;
  cache.cleaned(encoded.key);
  return {};
}

/// Looks at stored tiles that were not written since the opening, for those of the fast codec.
void Atlas::State::find_rested(std::size_t limit) {
  if (!rest_cursor) {
    if (rested.overflowed()) rest_cursor = TileKey::from_morton(0).value();  // Some were forgotten.
    rested = {};
    return;
  }
  auto stored = store.scan(shard, *rest_cursor, limit);
  if (!stored) {
    log_warning("shard {}: looking for rested tiles: {}", shard, stored.error().message);
    return;
  }
  for (const auto& tile : *stored) {
    const auto* cached = cache.peek(tile.key);
    const bool newest = cached == nullptr || cached->version == tile.version;
    const auto codec = codec_of(tile.bytes);
    const bool large = tile.bytes.size() >= options.rest_bytes;
    if (newest && large && codec && *codec == TileCodec::kFast) {
      rested.add(tile.key, tile.version, RestedTiles::Clock::time_point::min());
    }
  }
  rest_cursor.reset();
  if (stored->size() < limit) return;
  const auto next = TileKey::from_morton(stored->back().key.morton() + 1);
  if (next) rest_cursor = *next;
}

std::vector<TileInfo> Atlas::State::rested_tiles(std::size_t limit) {
  if (limit == 0) return {};
  if (rested.size() == 0) find_rested(limit);
  const auto before =
      RestedTiles::Clock::now() - std::chrono::duration_cast<RestedTiles::Clock::duration>(
                                      std::chrono::duration<double>(options.rest_seconds));
  std::vector<TileInfo> infos;
  for (const auto& tile : rested.oldest(limit, before)) infos.push_back({tile.key, tile.version});
  return infos;
}

}  // namespace voxatlas
