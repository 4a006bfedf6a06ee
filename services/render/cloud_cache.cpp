#include "render/cloud_cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "codec/tile_codec.hpp"

namespace voxatlas {

std::size_t CloudCache::Tile::bytes() const {
  std::size_t sum = sizeof(Tile) + encoded.capacity();
  for (const auto& cloud : clouds) sum += cloud ? cloud->memory_bytes() : 0;
  return sum;
}

void CloudCache::put(TileKey key, std::uint64_t version, Bytes bytes) {
  Tile& tile = tiles_[key];
  if (tile.version >= version) return;
  if (tile.version != 0) bytes_ -= tile.bytes();
  tile.version = version;
  tile.encoded = std::move(bytes);
  tile.clouds = {};
  tile.picture = picture_;
  bytes_ += tile.bytes();
}

std::uint64_t CloudCache::version(TileKey key) const {
  const auto found = tiles_.find(key);
  return found == tiles_.end() ? 0 : found->second.version;
}

Result<const CellCloud*> CloudCache::cloud(TileKey key, int depth) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) {
    return fail(ErrorCode::kNotFound, fmt::format("tile {:#x} is not in the cache", key.morton()));
  }
  Tile& tile = found->second;
  tile.picture = picture_;
  auto& cloud = tile.clouds[static_cast<std::size_t>(depth)];
  if (!cloud) {
    auto tree = decode_tile(tile.encoded);
    if (!tree) return pass_on(tree, fmt::format("tile {:#x}", key.morton()));
    cloud.emplace(*tree, depth);
    bytes_ += cloud->memory_bytes();
  }
  return &*cloud;
}

void CloudCache::trim() {
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
