// Tiles out: from memory, else from the store.
#include <fmt/format.h>

#include "atlas/atlas_state.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

Result<TileTree> Atlas::State::decode_stored(const StoredTile& stored) const {
  if (stored.tombstone()) return TileTree();
  auto tree = decode_tile(stored.bytes);
  if (!tree) {
    return pass_on(tree, fmt::format("shard {}, stored tile {:#x}, version {}", shard,
                                     stored.key.morton(), stored.version));
  }
  return tree;
}

Result<CachedTile*> Atlas::State::load(TileKey key) {
  if (auto* tile = cache.find(key)) return tile;
  ++counts.cache_misses;
  auto stored = store.get(shard, key);
  if (!stored) return pass_on(stored);
  if (!*stored) return nullptr;
  auto tree = decode_stored(**stored);
  if (!tree) return pass_on(tree);
  auto& tile = cache.insert(key, std::move(*tree), (*stored)->version);
  cache.evict(options.cache_bytes, key);  // Dirty tiles stay: reading needs no writing.
  return &tile;
}

Result<EncodedTile> Atlas::State::encoded(TileKey key, int depth) {
  const auto* cached = cache.peek(key);
  if (cached != nullptr && cached->dirty()) {
    const auto bytes = depth == kDepth
                           ? encode_tile(cached->tree, {TileCodec::kFast})
                           : encode_tile(cut_tile(cached->tree, depth), {TileCodec::kDense});
    return EncodedTile{key, cached->version, bytes};
  }
  auto stored = store.get(shard, key);
  if (!stored) return pass_on(stored);
  if (!*stored || (*stored)->tombstone()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("shard {} has no tile {:#x}", shard, key.morton()));
  }
  EncodedTile encoded{key, (*stored)->version, std::move((*stored)->bytes)};
  if (depth == kDepth) return encoded;
  auto cut = decode_tile_to_depth(encoded.bytes, depth);
  if (!cut) return pass_on(cut, fmt::format("shard {}, stored tile {:#x}", shard, key.morton()));
  encoded.bytes = encode_tile(*cut, {TileCodec::kDense});
  return encoded;
}

Result<std::vector<TileInfo>> Atlas::State::list(TileKey from, std::size_t limit) {
  constexpr std::size_t kReadAtOnce = 128;
  std::map<TileKey, std::uint64_t> found;
  auto next = Result<TileKey>(from);
  std::optional<TileKey> covered;  // Up to here the store was read; nullopt: to its end.
  for (bool more = true; more;) {
    auto stored = store.scan(shard, *next, kReadAtOnce);
    if (!stored) return pass_on(stored);
    for (const auto& tile : *stored) {
      if (!tile.tombstone()) found.emplace(tile.key, tile.version);
    }
    more = stored->size() == kReadAtOnce && found.size() < limit;
    if (stored->size() < kReadAtOnce) {
      covered.reset();
      break;
    }
    covered = stored->back().key;
    next = TileKey::from_morton(covered->morton() + 1);
    if (!next) break;  // That was the last key there can be.
  }
  for (auto tile = cache.by_key().lower_bound(from); tile != cache.by_key().end(); ++tile) {
    if (covered && tile->first > *covered) break;
    if (tile->second.dirty()) found.insert_or_assign(tile->first, tile->second.version);
  }
  std::vector<TileInfo> infos;
  for (const auto& [key, version] : found) {
    if (infos.size() == limit) break;
    infos.push_back({key, version});
  }
  return infos;
}

}  // namespace voxatlas
