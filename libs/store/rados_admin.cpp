// What is asked of a store as a whole: a copy, a check, its size.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>

#include "store/rados_state.hpp"
#include "store/rocksdb_store.hpp"
#include "store/store_copy.hpp"

namespace voxatlas {

/// Every shard that ever had an owner.
static Result<std::vector<ShardId>> all_shards(librados::IoCtx& pool) {
  constexpr std::string_view kPrefix = "shard-";
  std::vector<ShardId> shards;
  try {  // librados's iterator has no other way to say that the cluster failed.
    for (auto object = pool.nobjects_begin(); object != pool.nobjects_end(); ++object) {
      const std::string name = object->get_oid();
      if (!name.starts_with(kPrefix)) continue;
      ShardId shard = 0;
      const auto* end = name.data() + name.size();
      const auto parsed = std::from_chars(name.data() + kPrefix.size(), end, shard);
      if (parsed.ec == std::errc() && parsed.ptr == end) shards.push_back(shard);
    }
  } catch (const std::exception& e) {
    return fail(ErrorCode::kIo, fmt::format("listing the pool's objects: {}", e.what()));
  }
  return shards;
}

Result<std::vector<std::string>> RadosStore::State::value_names(ShardId id) {
  auto found = rows(shard_object(id), "", std::string(kValueRow), 10'000);
  if (!found) return pass_on(found);
  std::vector<std::string> names;
  for (const auto& [row, value] : *found) names.push_back(row.substr(kValueRow.size()));
  return names;
}

Status RadosStore::checkpoint(const std::string& directory) {
  auto shards = all_shards(state_->pool);
  if (!shards) return pass_on(shards);
  if (std::error_code none; std::filesystem::exists(directory, none)) {
    return fail(ErrorCode::kInvalid, directory + " is there already");
  }
  auto copy = RocksDbStore::open(directory);
  if (!copy) return pass_on(copy);
  std::vector<std::unique_lock<std::mutex>> held;  // No write of ours comes between.
  for (const auto shard : *shards) held.emplace_back(state_->slot(shard).mutex);
  for (const auto shard : *shards) {
    auto names = state_->value_names(shard);
    if (!names) return pass_on(names);
    auto epoch = (*copy)->acquire(shard);
    if (!epoch) return pass_on(epoch);
    const auto go_on = [](std::uint64_t) { return Status(); };
    auto copied = copy_shard(*this, **copy, shard, *epoch, *names, go_on);
    if (!copied) return pass_on(copied);
  }
  return {};
}

Status RadosStore::verify(ShardId id) {
  auto tiles = for_each_page(*this, id, [](const auto&) { return Status(); });
  if (!tiles) return tiles;
  if (auto ok = marks(id); !ok) return pass_on(ok);
  auto names = state_->value_names(id);
  if (!names) return pass_on(names);
  for (const auto& name : *names) {
    if (auto ok = value(id, name); !ok) return pass_on(ok);
  }
  return replay(id, [](JournalPosition, ByteView) -> Status { return {}; });
}

/// Of up to kSampled regions, evenly spread over the shard's; times as many more as there are.
Result<std::uint64_t> RadosStore::State::estimate_bytes(ShardId id) {
  constexpr std::size_t kSampled = 8;
  std::vector<std::uint64_t> regions;
  {
    auto owned = lock(id);
    if (!owned) return pass_on(owned);
    regions.assign(owned->shard->regions.begin(), owned->shard->regions.end());
  }
  if (regions.empty()) return 0;
  const std::size_t sampled = std::min(kSampled, regions.size());
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < sampled; ++i) {
    const auto region = regions[i * regions.size() / sampled];
    auto tiles = rows(region_object(id, region), "", "", 1'000);
    if (!tiles) return pass_on(tiles);
    for (const auto& [key, value] : *tiles) bytes += key.size() + value.length();
  }
  return bytes * regions.size() / sampled;
}

Result<std::uint64_t> RadosStore::disk_bytes() {
  constexpr auto kFresh = std::chrono::seconds(10);
  const std::lock_guard guard(state_->bytes_mutex);
  const auto now = std::chrono::steady_clock::now();
  if (state_->total_bytes && now - state_->total_at < kFresh) return *state_->total_bytes;
  std::vector<ShardId> ids;
  {
    const std::lock_guard shards_guard(state_->shards_mutex);
    for (const auto& [id, shard] : state_->shards) ids.push_back(id);
  }
  std::uint64_t bytes = 0;
  for (const auto id : ids) {
    auto estimated = state_->estimate_bytes(id);
    if (!estimated) return estimated;
    bytes += *estimated;
  }
  state_->total_bytes = bytes;
  state_->total_at = now;
  return bytes;
}

}  // namespace voxatlas
