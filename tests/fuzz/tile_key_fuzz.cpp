// Any 8 bytes are either refused or a tile that survives the way to metres and back, on every grid.
#include <cstring>

#include "base/check.hpp"
#include "grid/grid.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::uint64_t code = 0;
  if (size < sizeof code + 1) return 0;
  std::memcpy(&code, data, sizeof code);
  const auto grid = voxatlas::Grid::create(1 + data[sizeof code] % 20);
  VOX_CHECK(grid.has_value());
  const auto key = voxatlas::TileKey::from_morton(code);
  const auto tile = grid->tile_from_morton(code);
  VOX_CHECK(key.has_value() == (code >> 63 == 0));
  VOX_CHECK(key.has_value() || !tile.has_value());
  if (key) VOX_CHECK(voxatlas::TileKey::from_index(key->index()) == *key);
  if (tile) {
    VOX_CHECK(tile->morton() == code);
    VOX_CHECK(grid->tile_at(grid->min_corner(*tile)) == *tile);
  }
  return 0;
}
