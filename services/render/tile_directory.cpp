#include "render/tile_directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "grid/morton.hpp"

namespace voxatlas {
namespace {

constexpr unsigned kBlockShift = 4;

TileRange blocks_of(const TileRange& tiles) {
  TileRange blocks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks.min[axis] = tiles.min[axis] >> kBlockShift;
    blocks.max[axis] = tiles.max[axis] >> kBlockShift;
  }
  return blocks;
}

double count(const TileRange& range) {
  double product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= range.max[axis] - range.min[axis] + 1.0;
  return product;
}

void for_each(const TileRange& range, const std::function<void(const Index3&)>& visit) {
  for (std::uint32_t z = range.min[2]; z <= range.max[2]; ++z) {
    for (std::uint32_t y = range.min[1]; y <= range.max[1]; ++y) {
      for (std::uint32_t x = range.min[0]; x <= range.max[0]; ++x) visit({x, y, z});
    }
  }
}

/// The tiles of some blocks, those beyond the grid's end left out.
TileRange tiles_of_blocks(const TileRange& blocks, const Grid& grid) {
  TileRange tiles;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    tiles.min[axis] = blocks.min[axis] << kBlockShift;
    tiles.max[axis] =
        std::min(((blocks.max[axis] + 1) << kBlockShift) - 1, grid.tiles_per_axis() - 1);
  }
  return tiles;
}

Box box_of_block(const Index3& block, const Grid& grid) {
  Box box;
  const double edge = grid.tile_length() * (1u << kBlockShift);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    box.min[i] = edge * block[axis] - grid.tile_length() * grid.tiles_per_axis() / 2;
    box.max[i] = box.min[i] + edge;
  }
  return box;
}

Index3 block_of(TileKey key) {
  Index3 index = key.index();
  for (auto& i : index) i >>= kBlockShift;
  return index;
}

void widen(std::optional<TileRange>& range, const Index3& index) {
  if (!range) range = TileRange{index, index};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range->min[axis] = std::min(range->min[axis], index[axis]);
    range->max[axis] = std::max(range->max[axis], index[axis]);
  }
}

}  // namespace

Result<TileDirectory::View> TileDirectory::look(const Camera& camera, std::int64_t now) {
  const TileRange range = blocks_of(tiles_of(grid_, camera.bounds()));
  if (count(range) > static_cast<double>(kMaxView)) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("camera: the box around its view is {:.0f} blocks of 205 m, more than "
                            "{}: look less far or less wide",
                            count(range), kMaxView));
  }
  const Frustum frustum(camera);
  View view;
  view.listed_at = now;
  std::optional<TileRange> unlisted, old;
  std::vector<TileKey> known;
  for_each(range, [&](const Index3& index) {
    if (!frustum.may_see(box_of_block(index, grid_))) return;
    const auto found = blocks_.find(morton_encode(index));
    if (found == blocks_.end()) return widen(unlisted, index);
    Block& block = found->second;
    block.used_at = now;
    if (now - block.listed_at >= kFresh) widen(old, index);
    view.listed_at = std::min(view.listed_at, block.listed_at);
    for (const auto& [key, state] : block.tiles) known.push_back(key);
  });
  if (unlisted) view.listed_at = 0;
  if (const auto& ask = unlisted ? unlisted : old) view.to_list = tiles_of_blocks(*ask, grid_);
  view.tiles = tiles_in_view(camera, grid_, known);
  return view;
}

void TileDirectory::take(const TileRange& range, const std::vector<ListedTile>& tiles,
                         std::int64_t asked) {
  for_each(blocks_of(range), [&](const Index3& index) {
    Block& block = blocks_[morton_encode(index)];
    block.listed_at = std::max(block.listed_at, asked);
    block.used_at = std::max(block.used_at, asked);
  });
  for (const auto& tile : tiles) {
    const auto block = blocks_.find(morton_encode(block_of(tile.key)));
    if (block == blocks_.end()) continue;  // Not in the range: it was not asked for.
    Known& known = block->second.tiles[tile.key];
    if (known.told_at + kBelieved < asked) known.version = 0;
    if (tile.version >= known.version) known = {tile.version, asked};
  }
  forget_some();
}

bool TileDirectory::update(TileKey key, std::uint64_t version, std::int64_t now) {
  const auto block = blocks_.find(morton_encode(block_of(key)));
  if (block == blocks_.end()) return false;
  Known& known = block->second.tiles[key];
  if (version > known.version) known = {version, now};
  return now - block->second.used_at < kBelieved;
}

std::uint64_t TileDirectory::version(TileKey key) const {
  const auto block = blocks_.find(morton_encode(block_of(key)));
  if (block == blocks_.end()) return 0;
  const auto tile = block->second.tiles.find(key);
  return tile == block->second.tiles.end() ? 0 : tile->second.version;
}

void TileDirectory::forget_some() {
  if (blocks_.size() <= kMaxBlocks) return;
  std::vector<std::pair<std::int64_t, BlockCode>> oldest_first;
  for (const auto& [code, block] : blocks_) oldest_first.emplace_back(block.used_at, code);
  std::sort(oldest_first.begin(), oldest_first.end());
  for (const auto& [used_at, code] : oldest_first) {
    if (blocks_.size() <= kMaxBlocks / 2) return;  // Not a few each time: sorting is dear.
    blocks_.erase(code);
  }
}

}  // namespace voxatlas
