#include "atlas/tile_cache.hpp"

#include "base/check.hpp"

namespace voxatlas {

/// What a tile costs beside its tree: nodes of the maps it stands in.
static constexpr std::size_t kEntryBytes = 192;

CachedTile* TileCache::find(TileKey key) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) return nullptr;
  use(key, found->second);
  return &found->second;
}

const CachedTile* TileCache::peek(TileKey key) const {
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? nullptr : &found->second;
}

CachedTile& TileCache::insert(TileKey key, TileTree tree, std::uint64_t version) {
  const auto [at, is_new] = tiles_.try_emplace(key);
  VOX_CHECK(is_new);
  at->second.tree = std::move(tree);
  at->second.version = version;
  recount(at->second);
  use(key, at->second);
  return at->second;
}

void TileCache::changed(TileKey key, JournalPosition position) {
  auto& tile = tiles_.at(key);
  VOX_CHECK(position != 0);
  ++tile.version;
  recount(tile);
  if (tile.dirty()) return;
  clean_.erase(tile.used);
  tile.first_change = position;
  dirty_.emplace(position, key);
}

void TileCache::cleaned(TileKey key) {
  auto& tile = tiles_.at(key);
  recount(tile);
  if (!tile.dirty()) return;
  dirty_.erase({tile.first_change, key});
  tile.first_change = 0;
  clean_.emplace(tile.used, key);
}

void TileCache::clear() { *this = TileCache(); }

bool TileCache::evict(std::size_t budget, std::optional<TileKey> keep) {
  auto oldest = clean_.begin();
  while (bytes_ > budget && oldest != clean_.end()) {
    if (oldest->second == keep) {
      ++oldest;
      continue;
    }
    const auto tile = tiles_.find(oldest->second);
    bytes_ -= tile->second.bytes;
    tiles_.erase(tile);
    oldest = clean_.erase(oldest);
  }
  return bytes_ <= budget;
}

std::vector<TileKey> TileCache::oldest_dirty(std::size_t limit) const {
  std::vector<TileKey> keys;
  for (const auto& [position, key] : dirty_) {
    if (keys.size() == limit) break;
    keys.push_back(key);
  }
  return keys;
}

std::optional<JournalPosition> TileCache::oldest_change() const {
  if (dirty_.empty()) return std::nullopt;
  return dirty_.begin()->first;
}

void TileCache::use(TileKey key, CachedTile& tile) {
  if (!tile.dirty()) clean_.erase(tile.used);
  tile.used = ++clock_;
  if (!tile.dirty()) clean_.emplace(tile.used, key);
}

void TileCache::recount(CachedTile& tile) {
  bytes_ -= tile.bytes;
  tile.bytes = tile.tree.memory_bytes() + kEntryBytes;
  bytes_ += tile.bytes;
}

}  // namespace voxatlas
