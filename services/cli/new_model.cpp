#include "cli/new_model.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "atlas/atlas.hpp"
#include "cli/model_folder.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {

/// All shards are open at once: little memory each.
static RocksDbOptions writing_options() {
  RocksDbOptions options;
  options.sync = false;
  options.memory_bytes = std::size_t{9} << 20;
  options.write_buffer_bytes = std::size_t{8} << 20;
  return options;
}

Result<NewModel> NewModel::create(const std::string& directory, const ModelParameters& parameters) {
  if (auto ok = parameters.check(); !ok) return pass_on(ok);
  std::error_code error;
  if (!std::filesystem::create_directories(directory, error)) {
    return fail(ErrorCode::kIo, fmt::format("cannot make {}: {}", directory,
                                            error ? error.message() : "it is there already"));
  }
  NewModel made;
  made.directory_ = directory;
  for (ShardId shard = 0; shard < parameters.shards; ++shard) {
    auto store = RocksDbStore::open(shard_folder(directory, shard), writing_options());
    if (!store) return pass_on(store);
    auto atlas = Atlas::open(**store, shard, parameters, AtlasOptions{});  // Stores the parameters.
    if (!atlas) return pass_on(atlas);
    made.shards_.push_back({std::move(*store), (*atlas)->epoch(), 0});
  }
  return made;
}

Status NewModel::put(const std::vector<StoredTile>& tiles) {
  std::vector<std::vector<StoredTile>> parts(shards_.size());
  for (const auto& tile : tiles) {
    parts[shard_of(tile.key, static_cast<std::uint32_t>(shards_.size()))].push_back(tile);
  }
  for (ShardId id = 0; id < shards_.size(); ++id) {
    auto& shard = shards_[id];
    if (auto ok = shard.store->put(id, shard.epoch, parts[id]); !ok) return ok;
    shard.tiles += parts[id].size();
    tiles_ += parts[id].size();
  }
  return {};
}

Status NewModel::finish(const std::vector<Mark>& marks) {
  for (ShardId id = 0; id < shards_.size(); ++id) {
    auto& shard = shards_[id];
    if (auto ok = shard.store->trim(id, shard.epoch, 0, marks); !ok) return ok;
    shard.store.reset();
  }
  auto opened = ModelFolder::open(directory_);
  if (!opened) return pass_on(opened, "the new model");
  for (ShardId id = 0; id < shards_.size(); ++id) {
    std::uint64_t found = 0;
    auto counted = opened->for_each_page(id, [&](std::vector<StoredTile>& page) -> Status {
      found += page.size();
      return {};
    });
    if (!counted) return counted;
    if (found != shards_[id].tiles) {
      return fail(ErrorCode::kCorrupt, fmt::format("shard {} of the new model has {} tiles, not {}",
                                                   id, found, shards_[id].tiles));
    }
  }
  return {};
}

}  // namespace voxatlas
