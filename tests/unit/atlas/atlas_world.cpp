#include "atlas_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "octree/tile_hash.hpp"

namespace voxatlas::test {

/// A few hits, some with colour, and free bricks elsewhere; one in ten alters nothing.
TileDelta World::delta() {
  TileDelta delta;
  if (random.below(10) == 0) return delta;
  delta.misses.depth = kBrickDepth;
  for (auto count = random.below(20); count > 0; --count) {
    const std::uint32_t brick = random.below(64);
    if (random.below(3) == 0) {
      delta.misses.insert(CellKey{kBrickDepth, 64 + brick});
    } else {
      delta.hits.insert(CellKey{kDepth, brick * 512 + random.below(512)});
    }
  }
  delta.hits.for_each([&](CellKey cell) {
    if (random.below(3) == 0) delta.coloured.insert(cell);
  });
  for (auto count = delta.coloured.size(); count > 0; --count) {
    delta.colours.push_back(random.colour());
  }
  return delta;
}

ShardScan World::next_scan(const std::string& source, std::int64_t session, std::int64_t ahead) {
  ShardScan scan{source, session, mark(source, session) + 1 + ahead, {}};
  std::set<TileKey> touched;
  for (auto count = random.below(6); count > 0; --count)
    touched.insert(key(random.below(tile_count_)));
  for (const auto tile : touched) {
    scan.deltas.emplace_back(tile, delta_bytes(delta()));
  }
  return scan;
}

std::vector<TileChange> World::add(const ShardScan& scan) {
  std::vector<TileChange> changes;
  for (const auto& [at, bytes] : scan.deltas) {
    auto& tile = tiles[at];
    tile.tree.apply(decode_delta(bytes).value(), random.model());
    changes.push_back({at, ++tile.version, bytes});
  }
  marks_[{scan.source, scan.session}] = scan.seq;
  return changes;
}

std::int64_t World::mark(const std::string& source, std::int64_t session) const {
  const auto found = marks_.find({source, session});
  return found == marks_.end() ? -1 : found->second;
}

std::string World::difference(Atlas& atlas) const {
  for (const auto& [session, seq] : marks_) {
    const auto mark = atlas.mark(session.first, session.second);
    if (mark != seq) return fmt::format("mark of {}: {}, not {}", session.first, mark, seq);
  }
  if (atlas.marks().size() != marks_.size()) return "the number of marks";
  const auto infos = atlas.list(key(0), 1'000'000);
  if (!infos) return infos.error().message;
  if (infos->size() != tiles.size()) {
    return fmt::format("{} tiles listed, not {}", infos->size(), tiles.size());
  }
  auto info = infos->begin();
  for (const auto& [at, expected] : tiles) {
    const auto name = fmt::format("tile {}", at.morton());
    if (info->key != at) return name + " is not listed";
    if (info->version != expected.version) {
      return fmt::format("{}: version {}, not {}", name, info->version, expected.version);
    }
    ++info;
    const auto tile = atlas.tile(at);
    if (!tile) return tile.error().message;
    if (tile->tree == nullptr) return name + " is not there";
    if (tile->version != expected.version) return name + ": version in memory";
    if (!(*tile->tree == expected.tree)) return name + " differs";
    if (tile_hash(at, *tile->tree) != tile_hash(at, expected.tree)) return name + ": hash";
  }
  return {};
}

Result<std::vector<TileChange>> changes_of(Atlas& atlas, std::span<const ShardScan> scans) {
  std::vector<TileChange> changes;
  auto done = atlas.commit(scans, [&](const TileChange& change) { changes.push_back(change); });
  if (!done) return pass_on(done);
  return changes;
}

bool same(std::vector<TileChange> a, std::vector<TileChange> b) {
  for (auto* changes : {&a, &b}) {
    std::ranges::stable_sort(*changes, {}, &TileChange::key);
  }
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.key == y.key && x.version == y.version && x.delta == y.delta;
  });
}

}  // namespace voxatlas::test
