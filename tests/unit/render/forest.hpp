#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "octree/tile_tree.hpp"
#include "render/tree_numbers.hpp"

namespace voxatlas::test {

/// The render trees of some tiles, in order of key, and the cell of each of their nodes; owns them.
class Forest {
 public:
  explicit Forest(const std::map<TileKey, TileTree>& tiles) {
    trees_.reserve(tiles.size());  // Trees must not move: placed_ points at them.
    for (const auto& [key, tile] : tiles) {
      const RenderTree& tree = trees_.emplace_back(tile);
      placed_.push_back({key, &tree});
      for (std::uint32_t node = 0; node < tree.node_count(); ++node) {
        cells_.emplace_back(key, tree.key_of(node));
      }
    }
  }
  Forest(const Forest&) = delete;
  Forest& operator=(const Forest&) = delete;

  const std::vector<PlacedTree>& placed() const { return placed_; }
  /// By its number in a CellImage, from 1.
  const std::pair<TileKey, CellKey>& cell(std::uint32_t number) const { return cells_[number - 1]; }

 private:
  std::vector<RenderTree> trees_;
  std::vector<PlacedTree> placed_;
  std::vector<std::pair<TileKey, CellKey>> cells_;
};

}  // namespace voxatlas::test
