#include "atlas/rested_tiles.hpp"

namespace voxatlas {

void RestedTiles::add(TileKey key, std::uint64_t version, Clock::time_point since) {
  remove(key);
  if (tiles_.size() == kLimit) {
    remove(tiles_.front().key);
    overflowed_ = true;
  }
  tiles_.push_back({key, version, since});
  by_key_.emplace(key, std::prev(tiles_.end()));
}

void RestedTiles::remove(TileKey key) {
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return;
  tiles_.erase(found->second);
  by_key_.erase(found);
}

std::vector<RestedTiles::Tile> RestedTiles::oldest(std::size_t limit,
                                                   Clock::time_point before) const {
  std::vector<Tile> rested;
  for (const auto& tile : tiles_) {
    if (rested.size() == limit || tile.since > before) break;
    rested.push_back(tile);
  }
  return rested;
}

}  // namespace voxatlas
