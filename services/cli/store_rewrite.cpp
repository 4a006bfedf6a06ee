// checkpoint, reshard and merge: a model made of others, whole or not at all.
#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>

#include "atlas/tile_merge.hpp"
#include "bus/service_loop.hpp"
#include "cli/model_folder.hpp"
#include "cli/new_model.hpp"
#include "cli/progress.hpp"
#include "cli/running_copy.hpp"
#include "cli/store.hpp"
#include "codec/tile_codec.hpp"

namespace voxatlas {

namespace fs = std::filesystem;

static Status refuse_existing(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{} is there already: look at it, then remove or rename it", path));
}

static tl::unexpected<Error> refused(const std::string& what) {
  return fail(ErrorCode::kIo, fmt::format("{}: {}", what, std::strerror(errno)));
}

static Status refuse_cluster(const std::string& place) {
  auto location = StoreLocation::parse(place);
  if (!location) return pass_on(location);
  if (location->embedded()) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{} is no folder: make one of it with `voxatlas store copy`, and go on "
                          "with that",
                          place));
}

/// The folder without a slash at its end, as names are made from it.
static Result<std::string> folder_name(const std::string& directory) {
  if (auto folder = refuse_cluster(directory); !folder) return pass_on(folder);
  std::error_code error;
  const auto path = fs::canonical(directory, error);
  if (!error) return path.string();
  return fail(ErrorCode::kNotFound, fmt::format("{}: {}", directory, error.message()));
}

/// The new model takes the old one's name in one step, so that there is always one of that name.
static Status take_place(const std::string& made, const std::string& directory,
                         const std::string& kept) {
  ::sync();
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, directory.c_str(), RENAME_EXCHANGE) != 0) {
    return refused(fmt::format("{} is whole, but cannot take the place of {}", made, directory));
  }
  if (::rename(made.c_str(), kept.c_str()) != 0) {
    return refused(fmt::format("the model before is in {}, which cannot be named {}", made, kept));
  }
  ::sync();
  fmt::print("{}: done; the model before is kept in {}\n", directory, kept);
  return {};
}

static Status copy_at_rest(const std::string& directory, const std::string& copy) {
  auto model = ModelFolder::open(directory);
  if (!model) return pass_on(model);
  std::error_code error;
  if (!fs::create_directories(copy, error)) {
    return fail(ErrorCode::kIo, fmt::format("cannot make {}: {}", copy, error.message()));
  }
  for (ShardId shard = 0; shard < model->shards(); ++shard) {
    auto made = model->store(shard).checkpoint(shard_folder(copy, shard));
    if (!made) return made;
  }
  return {};
}

Status run_store_checkpoint(const StoreOptions& options) {
  for (const auto& place : {options.data_dir, options.target}) {
    if (auto folder = refuse_cluster(place); !folder) return folder;
  }
  const std::string partial = options.target + ".partial";
  for (const auto& path : {options.target, partial}) {
    if (auto ok = refuse_existing(path); !ok) return ok;
  }
  auto copied = copy_at_rest(options.data_dir, partial);
  if (!copied && copied.error().code == ErrorCode::kUnavailable) {
    copied = copy_running(options.url, options.data_dir, partial);
  }
  if (!copied) return pass_on(copied, fmt::format("{}, if there, is unfinished", partial));
  ShardId shards = 0;
  {
    auto copy = ModelFolder::open(partial);
    if (!copy) return pass_on(copy, "the copy");
    shards = copy->shards();
  }
  ::sync();
  if (::rename(partial.c_str(), options.target.c_str()) != 0) return refused(partial);
  fmt::print("{}: a model of {} shards\n", options.target, shards);
  return {};
}

/// A tile of both: log-odds added, and as many changes as both have seen, so that no version falls.
static Result<StoredTile> merge_stored(StoredTile mine, const std::optional<StoredTile>& theirs,
                                       const SensorModel& sensor) {
  if (!theirs || theirs->tombstone()) return mine;
  StoredTile sum{mine.key, mine.version + theirs->version, theirs->bytes};
  if (mine.tombstone()) return sum;
  const auto what = fmt::format("tile {:#x}", mine.key.morton());
  auto tree = decode_tile(mine.bytes);
  if (!tree) return pass_on(tree, what);
  auto other = decode_tile(theirs->bytes);
  if (!other) return pass_on(other, what + " of the other model");
  merge_tile(*tree, *other, sensor);
  sum.bytes = encode_tile(*tree, {TileCodec::kFast});
  return sum;
}

/// One page of tiles into the new model, unless a signal has asked to stop.
static Status write_page(const std::vector<StoredTile>& page, NewModel& made) {
  if (!stop_requested()) return made.put(page);
  return fail(ErrorCode::kUnavailable, "stopped");
}

/// Every tile of `model`, with what `other` adds to it, into the new one.
static Status write_all(ModelFolder& model, ModelFolder* other, NewModel& made) {
  Progress progress;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    auto copied = model.for_each_page(shard, [&](std::vector<StoredTile>& page) -> Status {
      for (auto& tile : page) {
        if (other == nullptr) continue;
        auto theirs = other->get(tile.key);
        if (!theirs) return pass_on(theirs);
        auto sum = merge_stored(std::move(tile), *theirs, model.parameters().sensor);
        if (!sum) return pass_on(sum);
        tile = std::move(*sum);
      }
      progress.say(fmt::format("{} tiles written", made.tiles()));
      return write_page(page, made);
    });
    if (!copied) return copied;
  }
  return {};
}

/// The tiles that only `other` has, as they are.
static Status write_others_own(ModelFolder& model, ModelFolder& other, NewModel& made) {
  for (ShardId shard = 0; shard < other.shards(); ++shard) {
    auto copied = other.for_each_page(shard, [&](std::vector<StoredTile>& page) -> Status {
      std::vector<StoredTile> own;
      for (auto& tile : page) {
        auto mine = model.get(tile.key);
        if (!mine) return pass_on(mine);
        if (!*mine) own.push_back(std::move(tile));
      }
      return write_page(own, made);
    });
    if (!copied) return copied;
  }
  return {};
}

/// The marks of both. A session that both have seen would count twice.
static Result<std::vector<Mark>> joined_marks(ModelFolder& model, ModelFolder& other) {
  auto marks = model.common_marks();
  if (!marks) return marks;
  auto others = other.common_marks();
  if (!others) return pass_on(others, "the other model");
  std::set<std::pair<std::string, std::int64_t>> sessions;
  for (const auto& mark : *marks) sessions.emplace(mark.source, mark.session);
  for (const auto& mark : *others) {
    if (!sessions.emplace(mark.source, mark.session).second) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("both models hold scans of source \"{}\", session {}: they would "
                              "count twice",
                              mark.source, mark.session));
    }
    marks->push_back(mark);
  }
  return marks;
}

/// Log-odds can be added where cells and clamps are the same; how they were measured may differ.
static Status check_alike(const ModelParameters& mine, const ModelParameters& theirs) {
  ModelParameters other = theirs;
  other.shards = mine.shards;
  other.integration = mine.integration;
  other.sensor.hit = mine.sensor.hit;
  other.sensor.miss = mine.sensor.miss;
  if (other == mine) return {};
  return fail(ErrorCode::kInvalid, fmt::format("the other model cannot be added, it has {}",
                                               describe_difference(other, mine)));
}

/// Makes the new model beside the old one, both open only in here.
static Status write_new(const std::string& name, const std::string& other_directory,
                        std::uint32_t shards, const std::string& made_in) {
  auto model = ModelFolder::open(name);
  if (!model) return pass_on(model);
  std::optional<ModelFolder> other;
  if (!other_directory.empty()) {
    auto opened = ModelFolder::open(other_directory);
    if (!opened) return pass_on(opened);
    if (auto ok = check_alike(model->parameters(), opened->parameters()); !ok) return ok;
    if (auto ok = opened->settle(); !ok) return ok;
    other = std::move(*opened);
  }
  if (auto ok = model->settle(); !ok) return ok;
  auto marks = other ? joined_marks(*model, *other) : model->common_marks();
  if (!marks) return pass_on(marks);
  ModelParameters parameters = model->parameters();
  if (shards != 0) parameters.shards = shards;
  auto made = NewModel::create(made_in, parameters);
  if (!made) return pass_on(made);
  auto written = write_all(*model, other ? &*other : nullptr, *made);
  if (written && other) written = write_others_own(*model, *other, *made);
  if (written) written = made->finish(*marks);
  if (!written) return pass_on(written, fmt::format("{} is left unfinished", made_in));
  return {};
}

/// Makes the new model and lets it take the old one's place; stopped by a signal, nothing is left.
static Status rewrite(const std::string& directory, const std::string& other_directory,
                      std::uint32_t shards, const std::string& kept_as) {
  auto name = folder_name(directory);
  if (!name) return pass_on(name);
  const std::string made_in = *name + ".partial", kept = *name + kept_as;
  for (const auto& path : {made_in, kept}) {
    if (auto ok = refuse_existing(path); !ok) return ok;
  }
  auto written = write_new(*name, other_directory, shards, made_in);
  std::error_code error;
  if (!written && stop_requested() && fs::remove_all(made_in, error) > 0 && !error) {
    return fail(ErrorCode::kUnavailable, fmt::format("stopped; {} is as it was", *name));
  }
  if (!written) return written;
  return take_place(made_in, *name, kept);
}

Status run_store_reshard(const StoreOptions& options) {
  return rewrite(options.data_dir, "", options.shards, ".before-reshard");
}

Status run_store_merge(const StoreOptions& options) {
  return rewrite(options.data_dir, options.target, 0, ".before-merge");
}

}  // namespace voxatlas
