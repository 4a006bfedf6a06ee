#include "cli/running_copy.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

#include "cli/model_client.hpp"

namespace voxatlas {

namespace fs = std::filesystem;

/// A checkpoint writes what is in memory and syncs it: seconds on a slow disk.
static constexpr std::int64_t kPatience = 120'000'000;

Status move_folder(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error == std::errc::cross_device_link) {
    fs::copy(from, to, fs::copy_options::recursive, error);
    if (!error) fs::remove_all(from, error);
  }
  if (!error) return {};
  return fail(ErrorCode::kIo, fmt::format("cannot move {} to {}: {}", from, to, error.message()));
}

/// One shard's copy, out of the folder that its tile store names.
static Status fetch_shard(StoreClient& stores, ShardId shard, const std::string& data_dir,
                          const std::string& folder) {
  auto named = stores.checkpoint(static_cast<std::int32_t>(shard), kPatience);
  if (!named) return pass_on(named);
  const fs::path name(*named);
  if (!named->starts_with("checkpoint-") || name != name.filename()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tilestore {} names the folder {}", shard, *named));
  }
  const std::string made = data_dir + "/" + *named;
  std::error_code error;
  if (!fs::exists(shard_folder(made, shard), error)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("the set of services on this bus works on another folder than {}: {} "
                            "is not there",
                            data_dir, shard_folder(made, shard)));
  }
  if (auto moved = move_folder(shard_folder(made, shard), shard_folder(folder, shard)); !moved) {
    return moved;
  }
  fs::remove(made, error);
  return {};
}

Status copy_running(const std::string& url, const std::string& data_dir,
                    const std::string& folder) {
  auto client = ModelClient::connect(url);
  if (!client) return pass_on(client, data_dir + " is in use");
  std::error_code error;
  if (!fs::create_directories(folder, error)) {
    return fail(ErrorCode::kIo, fmt::format("cannot make {}: {}", folder, error.message()));
  }
  for (ShardId shard = 0; shard < (*client)->parameters().shards; ++shard) {
    if (auto ok = fetch_shard((*client)->stores(), shard, data_dir, folder); !ok) return ok;
  }
  return {};
}

Result<ReadableModel> ReadableModel::open(const std::string& data_dir, const std::string& url) {
  ReadableModel readable;
  auto model = ModelFolder::open(data_dir);
  const bool running = !model && model.error().code == ErrorCode::kUnavailable;
  if (const auto place = StoreLocation::parse(data_dir); running && place && place->embedded()) {
    readable.copy_ = fmt::format("{}/looked-at-{}", data_dir, ::getpid());
    if (auto ok = copy_running(url, data_dir, readable.copy_); !ok) return pass_on(ok);
    model = ModelFolder::open(readable.copy_);
  }
  if (!model) return pass_on(model);
  readable.model_ = std::move(*model);
  return readable;
}

ReadableModel::ReadableModel(ReadableModel&& other) noexcept
    : copy_(std::exchange(other.copy_, {})), model_(std::move(other.model_)) {}

ReadableModel::~ReadableModel() {
  model_.reset();
  if (copy_.empty()) return;
  std::error_code ignored;
  fs::remove_all(copy_, ignored);
}

}  // namespace voxatlas
