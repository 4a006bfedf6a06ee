#include "tilestore/tile_contents.hpp"

namespace voxatlas {

Result<TileContents::Figures> TileContents::of(const TileInfo& tile) {
  const auto kept = kept_.find(tile.key);
  if (kept != kept_.end() && kept->second.version == tile.version) return kept->second;
  auto current = atlas_.tile(tile.key);
  if (!current) return pass_on(current);
  if (kept_.size() >= kMostKept) kept_.clear();
  return kept_[tile.key] = {current->version, tile_hash(tile.key, *current->tree),
                            current->tree->counts()};
}

}  // namespace voxatlas
