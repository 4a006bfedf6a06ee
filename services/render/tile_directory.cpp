#include "render/tile_directory.hpp"

#include <algorithm>

namespace voxatlas {
namespace {

bool holds(const TileRange& range, const Index3& index) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (index[axis] < range.min[axis] || index[axis] > range.max[axis]) return false;
  }
  return true;
}

}  // namespace

bool TileDirectory::knows(const TileRange& range, std::int64_t now) const {
  return listed_at_ != 0 && now - listed_at_ < kBelieved && holds(range_, range.min) &&
         holds(range_, range.max);
}

void TileDirectory::take(const TileRange& range, const std::vector<ListedTile>& tiles,
                         std::int64_t now) {
  range_ = range;
  listed_at_ = now;
  std::erase_if(versions_, [&](const auto& tile) { return !holds(range, tile.first.index()); });
  for (const auto& tile : tiles) update(tile.key, tile.version);
}

void TileDirectory::update(TileKey key, std::uint64_t version) {
  if (!holds(range_, key.index())) return;
  auto& known = versions_[key];
  known = std::max(known, version);
}

std::vector<TileKey> TileDirectory::keys() const {
  std::vector<TileKey> keys;
  keys.reserve(versions_.size());
  for (const auto& [key, version] : versions_) keys.push_back(key);
  return keys;
}

std::uint64_t TileDirectory::version(TileKey key) const {
  const auto found = versions_.find(key);
  return found == versions_.end() ? 0 : found->second;
}

}  // namespace voxatlas
