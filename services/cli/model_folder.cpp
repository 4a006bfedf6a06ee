#include "cli/model_folder.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "grid/region_key.hpp"

namespace voxatlas {

static constexpr std::size_t kTilesAPage = 256;

static std::string in_words(const StoreLocation& location, ShardId shard) {
  if (location.embedded()) return shard_folder(location.folder, shard);
  return fmt::format("shard {} of {}", shard, location.text());
}

static Result<std::unique_ptr<TileStore>> open_shard(const StoreLocation& location, ShardId shard) {
  std::error_code ignored;
  if (location.embedded() &&
      !std::filesystem::exists(shard_folder(location.folder, shard) + "/CURRENT", ignored)) {
    return fail(ErrorCode::kNotFound, fmt::format("there is no shard {} of a model: {} holds no "
                                                  "store",
                                                  shard, in_words(location, shard)));
  }
  RocksDbOptions options;
  options.create = false;
  auto store = open_store(location, shard, options);
  if (!store && location.embedded() && store.error().code == ErrorCode::kUnavailable) {
    return pass_on(store, "this needs a model at rest, stop the set of services first");
  }
  return store;
}

static Result<ModelParameters> parameters_of(TileStore& store, ShardId shard,
                                             const StoreLocation& location) {
  auto stored = Atlas::stored_parameters(store, shard);
  if (!stored) return pass_on(stored);
  if (*stored) return **stored;
  if (location.embedded()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} has no parameters", in_words(location, shard)));
  }
  return fail(ErrorCode::kNotFound, fmt::format("there is no {}", in_words(location, shard)));
}

/// Opening a folder is owning it; a cluster is told, and every earlier owner is fenced.
static Status own(TileStore& store, ShardId shard, const StoreLocation& location) {
  if (location.embedded()) return {};
  if (auto owned = store.acquire(shard); !owned) {
    return pass_on(owned, "this needs a model at rest, stop the set of services first");
  }
  return {};
}

static Result<bool> is_there(const StoreLocation& location, TileStore& store, ShardId shard) {
  std::error_code ignored;
  if (location.embedded()) {
    return std::filesystem::exists(shard_folder(location.folder, shard), ignored);
  }
  auto stored = Atlas::stored_parameters(store, shard);  // A cluster's store holds every shard.
  if (!stored) return pass_on(stored);
  return stored->has_value();
}

Result<ModelFolder> ModelFolder::open(const std::string& place) {
  auto location = StoreLocation::parse(place);
  if (!location) return pass_on(location);
  ModelFolder model;
  for (ShardId shard = 0; shard == 0 || shard < model.shards(); ++shard) {
    auto store = open_shard(*location, shard);
    if (!store) return pass_on(store);
    auto parameters = parameters_of(**store, shard, *location);
    if (!parameters) return pass_on(parameters);
    if (auto owned = own(**store, shard, *location); !owned) return pass_on(owned);
    if (shard == 0) model.parameters_ = *parameters;
    if (*parameters != model.parameters_) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: shard {} is of another model than shard 0: {}", place, shard,
                              describe_difference(*parameters, model.parameters_)));
    }
    model.stores_.push_back(std::move(*store));
  }
  auto more = is_there(*location, *model.stores_.back(), model.shards());
  if (!more) return pass_on(more);
  if (*more) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{} has {} shards, but there is {}", place, model.shards(),
                            in_words(*location, model.shards())));
  }
  return model;
}

Result<std::unique_ptr<Atlas>> ModelFolder::atlas(ShardId shard) {
  return Atlas::open(store(shard), shard, parameters_, AtlasOptions{});
}

Status ModelFolder::settle() {
  for (ShardId shard = 0; shard < shards(); ++shard) {
    auto opened = atlas(shard);
    if (!opened) return pass_on(opened);
    if (auto flushed = (*opened)->flush(); !flushed) return flushed;
  }
  return {};
}

Status ModelFolder::for_each_page(ShardId shard, const VisitTiles& visit) {
  auto from = TileKey::from_morton(0);
  while (from) {
    auto page = store(shard).scan(shard, *from, kTilesAPage);
    if (!page) return pass_on(page);
    if (page->empty()) return {};
    from = TileKey::from_morton(page->back().key.morton() + 1);  // The last key there can be ends.
    if (auto ok = visit(*page); !ok) return ok;
  }
  return {};
}

static std::string in_words(const std::vector<Mark>& marks) {
  std::string text;
  for (const auto& mark : marks) {
    text += fmt::format("{}\"{}\" session {}: {}", text.empty() ? "" : ", ", mark.source,
                        mark.session, mark.seq);
  }
  return text.empty() ? "none" : text;
}

Result<std::vector<Mark>> ModelFolder::common_marks() {
  auto first = store(0).marks(0);
  if (!first) return first;
  for (ShardId shard = 1; shard < shards(); ++shard) {
    auto marks = store(shard).marks(shard);
    if (!marks) return marks;
    if (*marks == *first) continue;
    return fail(ErrorCode::kInvalid,
                fmt::format("the shards have not applied the same scans: shard 0 up to {}; shard "
                            "{} up to {}. Start the set, let publish end, stop the set",
                            in_words(*first), shard, in_words(*marks)));
  }
  return first;
}

Result<std::optional<StoredTile>> ModelFolder::get(TileKey key) {
  const ShardId shard = shard_of(key, shards());
  return store(shard).get(shard, key);
}

}  // namespace voxatlas
