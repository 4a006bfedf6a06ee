#include "cli/store.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <map>

#include "atlas/journal_record.hpp"
#include "atlas/tile_merge.hpp"
#include "cli/model_folder.hpp"
#include "grid/region_key.hpp"
#include "support/engine.hpp"
#include "support/temp_dir.hpp"
#include "unit/atlas/atlas_world.hpp"

namespace voxatlas {
namespace {

namespace fs = std::filesystem;

/// A model of several shards and, beside it, what it should know.
struct Written {
  Written(const std::string& directory, std::uint32_t shards, std::uint64_t seed,
          const std::string& source, int scans, std::int64_t late = 0)
      : world(seed, 600) {
    ModelParameters parameters;
    parameters.shards = shards;
    std::vector<ShardScan> all;
    for (int i = 0; i < scans; ++i) {
      all.push_back(world.next_scan(source, 1));
      world.add(all.back());
    }
    for (ShardId shard = 0; shard < shards; ++shard) {
      auto store = RocksDbStore::open(shard_folder(directory, shard)).value();
      auto atlas = Atlas::open(*store, shard, parameters, {}).value();
      // Half is written as tiles, half rests in the journal.
      for (int i = 0; i < scans - (shard == 1 ? late : 0); ++i) {
        const ShardScan part[] = {part_of(all[static_cast<std::size_t>(i)], shard, shards)};
        REQUIRE(atlas->commit(part).has_value());
        if (i == scans / 2) REQUIRE(atlas->flush().has_value());
      }
    }
  }

  static ShardScan part_of(const ShardScan& scan, ShardId shard, std::uint32_t shards) {
    ShardScan part{scan.source, scan.session, scan.seq, {}};
    for (const auto& delta : scan.deltas) {
      if (shard_of(delta.first, shards) == shard) part.deltas.push_back(delta);
    }
    return part;
  }

  test::World world;
};

std::uint64_t any_seed() { return test::engine()(); }

/// Everything a folder knows, its journals applied.
std::map<TileKey, test::World::Tile> tiles_of(const std::string& directory) {
  std::map<TileKey, test::World::Tile> tiles;
  auto model = ModelFolder::open(directory);
  if (!model) FAIL(model.error().message);
  for (ShardId shard = 0; shard < model->shards(); ++shard) {
    auto atlas = model->atlas(shard).value();
    const auto infos = atlas->list(test::key(0), 100'000).value();
    for (const auto& info : infos) {
      REQUIRE(shard_of(info.key, model->shards()) == shard);
      auto& tile = tiles[info.key];
      tile.version = info.version;
      tile.tree = *atlas->tile(info.key).value().tree;
    }
  }
  return tiles;
}

bool same(const std::map<TileKey, test::World::Tile>& a,
          const std::map<TileKey, test::World::Tile>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.version == y.second.version &&
           x.second.tree == y.second.tree;
  });
}

std::string error_of(const Status& status) { return status ? "" : status.error().message; }

TEST_CASE("a checkpoint is a model of its own, with all tiles and marks", "[cli][store]") {
  const test::TempDir folder;
  const Written written(folder / "model", 2, any_seed(), "car", 60);
  REQUIRE(error_of(run_store_checkpoint({folder / "model", folder / "copy", {}})) == "");
  fs::remove_all(folder / "model");
  REQUIRE(same(tiles_of(folder / "copy"), written.world.tiles));
  REQUIRE(error_of(run_store_verify({folder / "copy", {}, {}})) == "");
  auto model = ModelFolder::open(folder / "copy").value();
  for (ShardId shard = 0; shard < 2; ++shard) {
    REQUIRE(model.atlas(shard).value()->mark("car", 1) == 59);
  }
}

TEST_CASE("a checkpoint never overwrites", "[cli][store]") {
  const test::TempDir folder;
  const Written written(folder / "model", 1, any_seed(), "car", 3);
  fs::create_directory(folder / "copy");
  REQUIRE(run_store_checkpoint({folder / "model", folder / "copy", {}}).error().code ==
          ErrorCode::kInvalid);
}

TEST_CASE("resharding moves every tile and loses no mark", "[cli][store]") {
  const test::TempDir folder;
  Written written(folder / "model", 2, any_seed(), "car", 60);
  for (const std::uint32_t shards : {5u, 1u, 2u}) {
    StoreOptions options{folder / "model", {}, {}, shards, false};
    CAPTURE(shards);
    REQUIRE(error_of(run_store_reshard(options)) == "");
    REQUIRE(error_of(run_store_verify(options)) == "");
    REQUIRE(same(tiles_of(folder / "model"), written.world.tiles));
    auto model = ModelFolder::open(folder / "model").value();
    REQUIRE(model.shards() == shards);
    REQUIRE(model.common_marks().value() == std::vector<Mark>{{"car", 1, 59}});
    fs::remove_all(folder / "model.before-reshard");
  }
}

TEST_CASE("shards that have not applied the same scans are not resharded", "[cli][store]") {
  const test::TempDir folder;
  const Written written(folder / "model", 2, any_seed(), "car", 20, 3);
  const auto refused = run_store_reshard({folder / "model", {}, {}, 3, false});
  REQUIRE(refused.error().code == ErrorCode::kInvalid);
  REQUIRE(refused.error().message.find("\"car\" session 1: 16") != std::string::npos);
  REQUIRE_FALSE(fs::exists(folder / "model.before-reshard"));
}

TEST_CASE("merging adds tile by tile, and what only one has is copied", "[cli][store][oracle]") {
  const test::TempDir folder;
  const Written a(folder / "a", 2, any_seed(), "car", 60);
  const Written b(folder / "b", 3, any_seed() + 1, "drone", 60);
  auto expected = a.world.tiles;
  for (const auto& [key, tile] : b.world.tiles) {
    auto& sum = expected[key];
    merge_tile(sum.tree, tile.tree, SensorModel::standard());
    sum.version += tile.version;
  }
  REQUIRE(expected.size() > a.world.tiles.size());
  REQUIRE(expected.size() > b.world.tiles.size());

  REQUIRE(error_of(run_store_merge({folder / "a", folder / "b", {}})) == "");

  REQUIRE(same(tiles_of(folder / "a"), expected));
  REQUIRE(same(tiles_of(folder / "b"), b.world.tiles));
  REQUIRE(same(tiles_of(folder / "a.before-merge"), a.world.tiles));
  REQUIRE(ModelFolder::open(folder / "a").value().common_marks().value() ==
          std::vector<Mark>{{"car", 1, 59}, {"drone", 1, 59}});
  fs::remove_all(folder / "a.before-merge");
  const auto twice = run_store_merge({folder / "a", folder / "b", {}});
  REQUIRE(twice.error().message.find("count twice") != std::string::npos);
}

TEST_CASE("a model in use, or none, is refused in words", "[cli][store]") {
  const test::TempDir folder;
  const Written written(folder / "model", 1, any_seed(), "car", 3);
  const auto owner = RocksDbStore::open(folder / "model/shard-0").value();
  const auto refused = run_store_compact({folder / "model", {}, {}});
  REQUIRE(refused.error().code == ErrorCode::kUnavailable);
  REQUIRE(refused.error().message.find("stop the set of services first") != std::string::npos);
  REQUIRE(run_store_verify({folder / "none", {}, {}}).error().code == ErrorCode::kNotFound);
  REQUIRE_FALSE(fs::exists(folder / "none"));
}

TEST_CASE("verify finds a damaged table, a tile in the wrong shard, a version that is missing",
          "[cli][store]") {
  const test::TempDir folder;
  const Written written(folder / "model", 2, any_seed(), "car", 40);
  const auto verified = [&] { return run_store_verify({folder / "model", {}, {}}); };
  REQUIRE(error_of(verified()) == "");
  const auto with_shard_0 = [&](const std::function<void(TileStore&, Epoch)>& work) {
    auto store = RocksDbStore::open(folder / "model/shard-0").value();
    work(*store, store->acquire(0).value());
  };
  SECTION("a tile in the wrong shard") {
    with_shard_0([](TileStore& store, Epoch epoch) {
      auto tile = store.scan(0, test::key(0), 1).value().front();
      while (shard_of(tile.key, 2) == 0) tile.key = test::key(tile.key.morton() + 1);
      REQUIRE(store.put(0, epoch, std::span(&tile, 1)).has_value());
    });
  }
  SECTION("a journal record that skips a version") {
    with_shard_0([](TileStore& store, Epoch epoch) {
      const auto tile = store.scan(0, test::key(0), 1).value().front();
      const Bytes delta = test::delta_bytes({});
      const Bytes records[] = {encode_record({"car", 1, 40, {{tile.key, 1000, delta}}})};
      REQUIRE(store.append(0, epoch, records).has_value());
    });
  }
  SECTION("bytes that are no tile") {
    with_shard_0([](TileStore& store, Epoch epoch) {
      auto tile = store.scan(0, test::key(0), 1).value().front();
      tile.bytes[tile.bytes.size() / 2] ^= 1;
      REQUIRE(store.put(0, epoch, std::span(&tile, 1)).has_value());
    });
  }
  REQUIRE(verified().error().code == ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace voxatlas
