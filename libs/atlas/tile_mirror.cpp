#include "atlas/tile_mirror.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"
#include "codec/tile_codec.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {

bool TileBox::holds(TileKey tile) const {
  const Index3 index = tile.index();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (index[axis] < min[axis] || index[axis] > max[axis]) return false;
  }
  return true;
}

TileMirror::TileMirror(const TileBox& box, int depth, const SensorModel& model)
    : box_(box), depth_(depth), model_(model) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
}

void TileMirror::on_change(TileKey key, std::uint64_t version, std::optional<ByteView> delta) {
  if (!box_.holds(key)) return;
  Tile& tile = tiles_[key];
  if (version <= tile.version || tile.waiting.contains(version)) return;
  ++counters_.changes;
  tile.newest = std::max(tile.newest, version);
  const bool applicable = delta && depth_ == kDepth;
  if (applicable && version == tile.version + 1 && apply(tile, version, *delta)) {
    apply_waiting(tile);
  } else if (applicable && version > tile.version + 1) {
    if (tile.waiting.size() >= kMostWaiting) tile.waiting.clear();  // The tile is fetched anyway.
    tile.waiting.emplace(version, Bytes(delta->begin(), delta->end()));
  }
  settle(key, tile);
}

void TileMirror::on_listed(TileKey key, std::uint64_t version) {
  if (!box_.holds(key)) return;
  Tile& tile = tiles_[key];
  tile.newest = std::max(tile.newest, version);
  settle(key, tile);
}

Status TileMirror::on_tile(TileKey key, std::uint64_t version, ByteView encoded) {
  const auto known = tiles_.find(key);
  if (known == tiles_.end() || version <= known->second.version) return {};
  auto tree = decode_tile_to_depth(encoded, depth_);
  if (!tree) {
    ++counters_.unusable;
    return pass_on(tree);
  }
  ++counters_.fetched;
  Tile& tile = known->second;
  tile.tree = std::move(*tree);
  tile.version = version;
  tile.newest = std::max(tile.newest, version);
  apply_waiting(tile);
  settle(key, tile);
  return {};
}

bool TileMirror::apply(Tile& tile, std::uint64_t version, ByteView bytes) {
  const auto delta = decode_delta(bytes);
  if (!delta) {
    ++counters_.unusable;
    return false;
  }
  tile.tree.apply(*delta, model_);
  tile.version = version;
  ++counters_.applied;
  return true;
}

/// Those that follow the version at hand, one after the other; older ones are forgotten.
void TileMirror::apply_waiting(Tile& tile) {
  auto& waiting = tile.waiting;
  waiting.erase(waiting.begin(), waiting.upper_bound(tile.version));
  while (!waiting.empty() && waiting.begin()->first == tile.version + 1) {
    const auto next = waiting.extract(waiting.begin());
    if (!apply(tile, next.key(), next.mapped())) return;
  }
}

/// Notes whether the tile is behind what was heard of it.
void TileMirror::settle(TileKey key, Tile& tile) {
  const bool is_behind = tile.version < tile.newest;
  if (is_behind == (tile.behind_since != 0)) return;
  if (is_behind) {
    ++counters_.gaps;
    tile.behind_since = ++falls_;
    behind_.emplace(tile.behind_since, key);
  } else {
    behind_.erase(std::exchange(tile.behind_since, 0));
  }
}

std::vector<TileKey> TileMirror::to_fetch(std::size_t limit) const {
  std::vector<TileKey> keys;
  for (const auto& [since, key] : behind_) {
    if (keys.size() >= limit) break;
    keys.push_back(key);
  }
  return keys;
}

void TileMirror::for_each(const Visit& visit) const {
  for (const auto& [key, tile] : tiles_) {
    if (tile.version > 0) visit(key, tile.version, tile.tree);
  }
}

}  // namespace voxatlas
