#include "render/tree_cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "codec/tile_codec.hpp"

namespace voxatlas {

std::size_t TreeCache::Tile::bytes() const {
  return sizeof(Tile) + encoded.capacity() + (tree ? tree->memory_bytes() : 0);
}

void TreeCache::put(TileKey key, std::uint64_t version, Bytes bytes) {
  Tile& tile = tiles_[key];
  if (tile.version >= version) return;
  if (tile.version != 0) bytes_ -= tile.bytes();
  tile.version = version;
  tile.encoded = std::move(bytes);
  tile.tree.reset();
  tile.picture = picture_;
  bytes_ += tile.bytes();
}

std::uint64_t TreeCache::version(TileKey key) const {
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? 0 : found->second.version;
}

Result<const RenderTree*> TreeCache::tree(TileKey key) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) {
    return fail(ErrorCode::kNotFound, fmt::format("tile {:#x} is not in the cache", key.morton()));
  }
  Tile& tile = found->second;
  tile.picture = picture_;
  if (!tile.tree) {
    auto decoded = decode_tile(tile.encoded);
    if (!decoded) return pass_on(decoded, fmt::format("tile {:#x}", key.morton()));
    tile.tree.emplace(*decoded, tile.version);
    bytes_ += tile.tree->memory_bytes();
  }
  return &*tile.tree;
}

void TreeCache::trim() {
  if (bytes_ <= budget_) return;
  std::vector<std::pair<std::uint64_t, TileKey>> oldest_first;
  for (const auto& [key, tile] : tiles_) {
    if (tile.picture != picture_) oldest_first.emplace_back(tile.picture, key);
  }
  std::sort(oldest_first.begin(), oldest_first.end());
  for (const auto& [picture, key] : oldest_first) {
    if (bytes_ <= budget_) return;
    const auto found = tiles_.find(key);
    bytes_ -= found->second.bytes();
    tiles_.erase(found);
  }
}

}  // namespace voxatlas
