// copy: a model from one place to another, a folder or a cluster each; taken up again where it was.
#include "store/store_copy.hpp"

#include <fmt/format.h>

#include "bus/service_loop.hpp"
#include "cli/model_folder.hpp"
#include "cli/progress.hpp"
#include "cli/store.hpp"

namespace voxatlas {
namespace {

struct Target {
  std::unique_ptr<TileStore> store;
  Epoch epoch = 0;
};

/// Empty, or an unfinished copy. Shard 0 speaks for all: it is the last to be called finished.
Status refuse_a_model(TileStore& store, const std::string& place) {
  auto unfinished = is_unfinished(store, 0);
  if (!unfinished) return pass_on(unfinished);
  if (*unfinished) return {};
  auto parameters = Atlas::stored_parameters(store, 0);
  if (!parameters) return pass_on(parameters);
  auto tiles = store.scan(0, TileKey::from_morton(0).value(), 1);
  if (!tiles) return pass_on(tiles);
  if (!*parameters && tiles->empty()) return {};
  return fail(ErrorCode::kInvalid, place + " holds a model already");
}

/// All shards, each told that it is not whole yet.
Result<std::vector<Target>> open_targets(const std::string& place, ShardId shards) {
  auto location = StoreLocation::parse(place);
  if (!location) return pass_on(location);
  std::vector<Target> targets;
  for (ShardId shard = 0; shard < shards; ++shard) {
    auto store = open_store(*location, shard);
    if (!store) return pass_on(store);
    if (shard == 0) {
      if (auto free = refuse_a_model(**store, place); !free) return pass_on(free);
    }
    auto epoch = (*store)->acquire(shard);
    if (!epoch) return pass_on(epoch);
    if (auto marked = mark_unfinished(**store, shard, *epoch, true); !marked) {
      return pass_on(marked);
    }
    targets.push_back({std::move(*store), *epoch});
  }
  return targets;
}

Status copy_all(ModelFolder& model, std::vector<Target>& targets) {
  const auto names = Atlas::value_names();
  Progress shown;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    const auto progress = [&](std::uint64_t tiles) -> Status {
      if (stop_requested()) {
        return fail(ErrorCode::kUnavailable, "stopped; the same command goes on from here");
      }
      shown.say(fmt::format("shard {}: {} tiles", shard, tiles));
      return {};
    };
    auto& target = targets[shard];
    auto copied =
        copy_shard(model.store(shard), *target.store, shard, target.epoch, names, progress);
    if (!copied) return pass_on(copied, fmt::format("shard {}", shard));
    fmt::print("shard {}: {} tiles, {} of them written now; {} journal records; SHA-256 {}\n",
               shard, copied->tiles, copied->written, copied->records, to_hex(copied->digest));
  }
  return {};
}

}  // namespace

Status run_store_copy(const StoreOptions& options) {
  auto model = ModelFolder::open(options.data_dir);
  if (!model) return pass_on(model);
  auto targets = open_targets(options.target, model->shards());
  if (!targets) return pass_on(targets);
  if (auto copied = copy_all(*model, *targets); !copied) return copied;
  for (ShardId left = model->shards(); left > 0; --left) {
    auto& target = (*targets)[left - 1];
    auto whole = mark_unfinished(*target.store, left - 1, target.epoch, false);
    if (!whole) return whole;
  }
  fmt::print("{}: a model of {} shards, the same as {}\n", options.target, model->shards(),
             options.data_dir);
  return {};
}

}  // namespace voxatlas
