#include "render/tree_cache.hpp"

#include <catch2/catch.hpp>

#include "codec/tile_codec.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

const SensorModel kSensor = SensorModel::standard();

TileKey key_at(std::uint32_t x) { return TileKey::from_index({x, 0, 0}).value(); }

TileTree tile_of(int cells) {
  TileTree tree;
  for (int i = 0; i < cells; ++i) {
    tree.set({kDepth, static_cast<std::uint32_t>(i * 977 % 2'000'000)}, {3000, {}});
  }
  return tree;
}

ArrivedTile arrived(TileKey key, std::uint64_t version, const TileTree& tree) {
  return {key, version, encode_tile(tree, {}), kDepth};
}

/// Builds what there is to build. Returns how many jobs that was.
int build_all(TreeCache& cache, TileKey key, std::int64_t now) {
  int jobs = 0;
  while (auto job = cache.job(key)) {
    cache.take(build(std::move(*job), kSensor), now);
    ++jobs;
  }
  return jobs;
}

TileDelta hits_of(int cells) {
  TileDelta delta;
  for (int i = 0; i < cells; ++i) delta.hits.insert({kDepth, static_cast<std::uint32_t>(i)});
  return delta;
}

TreeCache::Update change(TileKey key, std::uint64_t version, const TileDelta& delta,
                         std::int64_t utime) {
  TreeCache::Update update{key, version, 1, {}, {utime, utime + 300}};
  encode_delta(delta, update.payload);
  return update;
}

TEST_CASE("a tile is first coarse, then fine", "[render]") {
  TreeCache cache(1'000'000);
  const TileKey key = key_at(1);
  REQUIRE(cache.look(key, 3, 0).must_ask);
  REQUIRE_FALSE(cache.job(key).has_value());
  cache.take(arrived(key, 3, tile_of(1000)), 0);
  auto standing = cache.look(key, 3, 0);
  REQUIRE_FALSE(standing.must_ask);
  REQUIRE(standing.must_build);
  REQUIRE_FALSE(standing.tree);
  auto job = cache.job(key);
  REQUIRE(job->depth == TreeCache::kCoarse);
  REQUIRE_FALSE(cache.job(key).has_value());  // One at a time.
  cache.take(build(std::move(*job), kSensor), 0);
  standing = cache.look(key, 3, 0);
  REQUIRE(standing.tree);
  REQUIRE_FALSE(standing.complete);
  const std::size_t coarse = cache.bytes();
  REQUIRE(build_all(cache, key, 0) == 2);  // The tree, and its normals near the tile's faces.
  standing = cache.look(key, 3, 0);
  REQUIRE(standing.complete);
  REQUIRE(standing.smooth);
  REQUIRE(standing.tree->cell_count(kDepth) == RenderTree(tile_of(1000)).cell_count(kDepth));
  REQUIRE(standing.tree->version() == 3);
  REQUIRE(cache.bytes() > coarse);
  REQUIRE_FALSE(cache.look(key, 3, 0).must_build);
  REQUIRE(cache.look(key, 4, 1'000'000).must_ask);
}

TEST_CASE("a tile that changes is made of its bytes, while there is room for them", "[render]") {
  const std::size_t budget = GENERATE(1'000'000u, 20'000u);
  const bool room = budget == 1'000'000;
  TreeCache cache(budget);
  const TileKey key = key_at(1);
  const TileTree tile = tile_of(1000);
  cache.take(arrived(key, 3, tile), 0);
  build_all(cache, key, 0);
  const std::size_t with_bytes = cache.bytes();
  REQUIRE(with_bytes > 20'000);
  REQUIRE(cache.full() == (with_bytes - encode_tile(tile, {}).size() >= budget));
  cache.trim(200'000);
  REQUIRE((cache.bytes() == with_bytes) == room);
  REQUIRE(cache.look(key, 3, 200'000).complete);
  cache.update(change(key, 4, hits_of(5), 7'000), true, 200'000);
  const auto standing = cache.look(key, 4, 200'000);
  REQUIRE(standing.stale == TreeCache::Since{7'000, 7'300});
  REQUIRE(standing.must_build == room);
  REQUIRE(standing.must_ask != room);
  if (!room) return;
  build_all(cache, key, 200'000);
  REQUIRE(cache.look(key, 4, 200'000).complete);
}

TEST_CASE("a tile that comes into being is drawn without asking, where somebody looks",
          "[render]") {
  TreeCache cache(1'000'000);
  const TileKey seen = key_at(1), unseen = key_at(2), older = key_at(3);
  cache.update(change(seen, 1, hits_of(5), 7'000), true, 10);
  cache.update(change(unseen, 1, hits_of(5), 7'000), false, 10);
  cache.update(change(older, 2, hits_of(5), 7'000), true, 10);
  REQUIRE(cache.look(seen, 1, 10).stale.durable == 7'000);
  REQUIRE_FALSE(cache.look(seen, 1, 10).must_ask);
  REQUIRE(cache.look(unseen, 1, 10).must_ask);
  REQUIRE(cache.look(older, 2, 10).must_ask);
  build_all(cache, seen, 10);
  const auto standing = cache.look(seen, 1, 10);
  REQUIRE(standing.complete);
  TileTree truth;
  truth.apply(hits_of(5), kSensor);
  REQUIRE(standing.tree->cell_count(kDepth) == RenderTree(truth).cell_count(kDepth));
}

TEST_CASE("changes that a listing has overtaken are waited for, lost ones are not", "[render]") {
  const bool lost = GENERATE(false, true);
  TreeCache cache(1'000'000);
  const TileKey key = key_at(1);
  cache.take(arrived(key, 3, tile_of(1000)), 0);
  build_all(cache, key, 0);
  cache.hear(key, 3, 900'000);  // Nothing new.
  REQUIRE(cache.look(key, 3, 900'000).behind_since == 0);
  cache.hear(key, 5, 1'000'000);
  auto standing = cache.look(key, 5, 1'050'000);
  REQUIRE_FALSE(standing.complete);
  REQUIRE(standing.behind_since == 1'000'000);
  REQUIRE_FALSE(standing.must_ask);
  cache.update(change(key, 4, hits_of(5), 7'000), true, 1'060'000);
  build_all(cache, key, 1'060'000);
  REQUIRE_FALSE(cache.look(key, 5, 1'070'000).complete);
  if (lost) {
    standing = cache.look(key, 5, 1'200'000);
    REQUIRE(standing.must_ask);
    REQUIRE(standing.behind_since == 1'000'000);
    cache.take(arrived(key, 5, tile_of(1000)), 1'210'000);
  } else {
    cache.update(change(key, 5, hits_of(9), 8'000), true, 1'150'000);
  }
  build_all(cache, key, 1'210'000);
  standing = cache.look(key, 5, 1'210'000);
  REQUIRE(standing.complete);
  REQUIRE(standing.behind_since == 0);
  REQUIRE_FALSE(standing.must_ask);
}

TEST_CASE("of a tile that is not here the coarse cells are asked for first", "[render]") {
  TreeCache cache(1'000'000);
  const TileKey key = key_at(1);
  REQUIRE(cache.look(key, 3, 0).ask_depth == TreeCache::kCoarse);
  const TileTree tile = tile_of(1000);
  cache.take(ArrivedTile{key, 3, encode_tile(cut_tile(tile, 4), {}), 4}, 0);
  REQUIRE(cache.look(key, 3, 0).must_build);
  REQUIRE(build_all(cache, key, 0) == 1);
  auto standing = cache.look(key, 3, 0);
  REQUIRE(standing.tree->depth() == 4);
  REQUIRE(standing.tree->cell_count(4) == RenderTree(tile).cell_count(4));
  REQUIRE_FALSE(standing.complete);
  REQUIRE(standing.must_ask);
  REQUIRE(standing.ask_depth == kDepth);
  cache.take(arrived(key, 4, tile), 0);
  REQUIRE(build_all(cache, key, 0) == 2);
  REQUIRE(cache.look(key, 4, 0).complete);
}

TEST_CASE("a tree's normals are made anew when one beside it has come", "[render][oracle]") {
  TreeCache cache(10'000'000);
  TileTree wall;
  for (std::uint32_t i = 0; i < 2'097'152; i += 19) wall.set({kDepth, i}, {3000, {}});
  cache.take(arrived(key_at(1), 1, wall), 0);
  build_all(cache, key_at(1), 0);
  REQUIRE(cache.look(key_at(1), 1, 0).smooth);
  const std::uint64_t alone = cache.look(key_at(1), 1, 0).serial;
  cache.take(arrived(key_at(2), 1, wall), 0);
  build_all(cache, key_at(2), 0);
  REQUIRE_FALSE(cache.look(key_at(1), 1, 0).smooth);
  REQUIRE(build_all(cache, key_at(1), 0) == 1);
  const auto standing = cache.look(key_at(1), 1, 0);
  REQUIRE(standing.smooth);
  REQUIRE(standing.serial != alone);
  const RenderTree tree(wall, 1);
  TreesAround around(tree);
  around.set({1, 0, 0}, &tree);
  const RenderTree oracle = tree.with_borders(around);
  for (std::uint32_t node = 0; node < oracle.node_count(); ++node) {
    REQUIRE(standing.tree->paint(node).normal() == oracle.paint(node).normal());
  }
}

TEST_CASE("a cache drops what was used longest ago, never what is in use", "[render]") {
  TreeCache cache(400'000);
  std::int64_t now = 0;
  for (std::uint32_t i = 0; i < 30; ++i) {
    cache.take(arrived(key_at(i), 1, tile_of(2000)), now);
    build_all(cache, key_at(i), now);
    (void)cache.look(key_at(0), 1, now);  // Seen in every picture.
    now += 600'000;
    cache.trim(now);
  }
  REQUIRE(cache.look(key_at(0), 1, now).complete);
  REQUIRE_FALSE(cache.look(key_at(1), 1, now).complete);
  REQUIRE(cache.look(key_at(29), 1, now).complete);
  now += 10'000'000;
  cache.trim(now);
  REQUIRE(cache.bytes() <= 400'000);
}

TEST_CASE("a tile that is none is not asked for until it is newer", "[render]") {
  TreeCache cache(1'000'000);
  const TileKey key = key_at(1);
  cache.take(ArrivedTile{key, 2, {9, 9, 9}, kDepth}, 0);
  REQUIRE(build_all(cache, key, 0) == 1);
  REQUIRE(cache.broken() == 1);
  REQUIRE(cache.look(key, 2, 0).complete);
  REQUIRE_FALSE(cache.look(key, 3, 1'000).must_ask);  // It has only just come.
  REQUIRE(cache.look(key, 3, 1'000'000).must_ask);
  cache.take(ArrivedTile{key_at(2), 0, {}, kDepth}, 0);  // Never written.
  REQUIRE(cache.look(key_at(2), 7, 0).complete);
}

TileDelta random_delta(std::mt19937_64& rng) {
  TileDelta delta;
  for (int i = 0; i < 20; ++i) {
    const auto voxel = static_cast<std::uint32_t>(rng() % 4096);
    (i % 2 == 0 ? delta.hits : delta.misses).insert({kDepth, 2 * voxel + (i % 2 == 0)});
  }
  return delta;
}

/// Updates, answers and builds in any order, any of them lost, late or double; what is drawn in the
/// end must be what the store has.
TEST_CASE("whatever is lost on the way, a tile ends as the store has it", "[render][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto chance = [&](int percent) { return static_cast<int>(rng() % 100) < percent; };
  for (int round = 0; round < 60; ++round) {
    TreeCache cache(10'000'000);
    const TileKey key = key_at(1);
    const bool is_new = chance(50);
    TileTree truth = is_new ? TileTree() : tile_of(100);
    std::uint64_t version = is_new ? 0 : 1;
    std::int64_t now = 1;
    std::vector<ArrivedTile> answers;
    std::vector<TreeCache::Update> updates;
    std::optional<BuiltTile> building;
    for (int step = 0; step < 300; ++step) {
      now += chance(2) ? 3'000'000 : 1'000;
      if (chance(3)) cache.hear(key, version, now);
      const auto standing = cache.look(key, version, now);
      if (standing.must_ask && version > 0 && chance(30))
        answers.push_back(arrived(key, version, truth));
      if (!answers.empty() && chance(50)) {
        cache.take(answers.front(), now);
        if (!chance(10)) answers.erase(answers.begin());
      }
      if (!building && chance(50)) {
        if (auto job = cache.job(key)) building = build(std::move(*job), kSensor);
      }
      if (building && chance(50)) cache.take(std::move(*std::exchange(building, {})), now);
      if (chance(40)) {
        const TileDelta delta = random_delta(rng);
        truth.apply(delta, kSensor);
        ++version;
        TreeCache::Update update{key, version, 1, {}, now};
        encode_delta(delta, update.payload);
        if (chance(10)) update.content = 0, update.payload.clear();
        if (chance(10)) update.content = 2, update.payload = encode_tile(truth, {});
        if (!chance(10)) updates.push_back(update);
      }
      while (!updates.empty() && chance(70)) {
        cache.update(updates.front(), true, now);
        if (!chance(5)) updates.erase(updates.begin());
      }
    }
    for (const auto& update : updates) cache.update(update, true, now);
    for (int i = 0; i < 20 && !cache.look(key, version, now).complete; ++i) {
      now += 100'000;
      if (building) cache.take(std::move(*std::exchange(building, {})), now);
      if (cache.look(key, version, now).must_ask) cache.take(arrived(key, version, truth), now);
      build_all(cache, key, now);
    }
    const auto standing = cache.look(key, version, now);
    REQUIRE(standing.complete);
    REQUIRE(standing.tree->version() == version);
    const RenderTree oracle(truth, version);
    REQUIRE(standing.tree->node_count() == oracle.node_count());
    for (std::uint32_t node = 0; node < oracle.node_count(); ++node) {
      REQUIRE(standing.tree->key_of(node) == oracle.key_of(node));
      REQUIRE(standing.tree->paint(node).log_odds() == oracle.paint(node).log_odds());
    }
    REQUIRE(cache.broken() == 0);
  }
}

}  // namespace
}  // namespace voxatlas
