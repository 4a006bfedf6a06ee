#pragma once

#include <cstdint>
#include <vector>

#include "bus/requests.hpp"
#include "grid/grid.hpp"
#include "render/tile_source.hpp"

namespace voxatlas {

/// Tiles from the tile stores, by listing pages and fetching. Borrows `client`, which must outlive
/// it. `shards`: how many stores share the model.
TileSource store_tiles(StoreClient& client, const Grid& grid, std::int32_t shards);

/// The rows of one page. Errors: kCorrupt where rows and size contradict; kOutOfRange for a key
/// that the grid has not.
Result<std::vector<ListedTile>> listed_tiles(const tiles_reply_t& page, const Grid& grid);

}  // namespace voxatlas
