#include "atlas/tile_cache.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <list>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }

/// Oracle: one list, most recently used at the back, everything found by walking it.
struct Entry {
  TileKey key;
  std::uint64_t version;
  JournalPosition change;
};

class Oracle {
 public:
  std::list<Entry> entries;

  Entry* use(TileKey wanted) {
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const auto& entry) { return entry.key == wanted; });
    if (found == entries.end()) return nullptr;
    entries.splice(entries.end(), entries, found);
    return &entries.back();
  }
  void drop_clean(std::size_t count, TileKey keep) {
    for (auto at = entries.begin(); count > 0 && at != entries.end();) {
      const bool drop = at->change == 0 && at->key != keep;
      at = drop ? entries.erase(at) : std::next(at);
      count -= drop ? 1 : 0;
    }
  }
  std::vector<TileKey> dirty() const {
    std::vector<std::pair<JournalPosition, TileKey>> found;
    for (const auto& entry : entries) {
      if (entry.change != 0) found.emplace_back(entry.change, entry.key);
    }
    std::sort(found.begin(), found.end());
    std::vector<TileKey> keys;
    for (const auto& [change, at] : found) keys.push_back(at);
    return keys;
  }
};

std::size_t counted(const TileCache& cache) {
  std::size_t bytes = 0;
  for (const auto& [at, tile] : cache.by_key()) bytes += tile.bytes;
  return bytes;
}

TEST_CASE("a cache forgets what a list would, and never a dirty tile", "[atlas][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  TileCache cache;
  Oracle oracle;
  JournalPosition position = 0;
  for (int step = 0; step < 20'000; ++step) {
    const auto at = key(rng() % 40);
    auto* known = oracle.use(at);
    auto* tile = cache.find(at);
    REQUIRE((tile == nullptr) == (known == nullptr));
    if (tile == nullptr) {
      cache.insert(at, TileTree(), 7);
      oracle.entries.push_back({at, 7, 0});
      known = &oracle.entries.back();
    } else if (rng() % 3 == 0) {
      REQUIRE(tile->version == known->version);
      cache.changed(at, ++position);
      ++known->version;
      if (known->change == 0) known->change = position;
    } else if (rng() % 3 == 0) {
      cache.cleaned(at);
      known->change = 0;
    }
    if (rng() % 5 == 0) {
      const auto before = cache.tiles();
      const auto keep = key(rng() % 40);
      const bool enough = cache.evict(cache.bytes() * (rng() % 3) / 2, keep);
      oracle.drop_clean(before - cache.tiles(), keep);
      if (!enough) {
        for (const auto& [code, left] : cache.by_key()) REQUIRE((left.dirty() || code == keep));
      }
    }
    REQUIRE(cache.tiles() == oracle.entries.size());
    REQUIRE(cache.bytes() == counted(cache));
    REQUIRE(cache.oldest_dirty(100) == oracle.dirty());
    REQUIRE(cache.dirty_tiles() == oracle.dirty().size());
  }
}

TEST_CASE("a cache counts what its tiles hold as they grow", "[atlas]") {
  TileCache cache;
  auto& tile = cache.insert(key(1), TileTree(), 0);
  const auto empty = cache.bytes();
  for (std::uint32_t brick = 0; brick < 100; ++brick) {
    tile.tree.set(CellKey{kDepth, brick * 512}, {100, {}});
  }
  cache.changed(key(1), 1);
  REQUIRE(cache.bytes() > empty + 100 * 1024);
  REQUIRE_FALSE(cache.evict(0, std::nullopt));
  cache.cleaned(key(1));
  REQUIRE(cache.evict(0, std::nullopt));
  REQUIRE(cache.bytes() == 0);
}

}  // namespace
}  // namespace voxatlas
