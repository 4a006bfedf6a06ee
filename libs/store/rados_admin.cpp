// What is asked of a store as a whole: a copy, a check, its size.
#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <filesystem>

#include "store/rados_state.hpp"
#include "store/rocksdb_store.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

static constexpr std::size_t kTilesAtOnce = 256;
static constexpr std::size_t kRecordsAtOnce = 64;

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

/// Every tile of a shard, some at a time.
template <class Visit>
static Status for_each_page(RadosStore& store, ShardId shard, const Visit& visit) {
  for (auto from = TileKey::from_morton(0); from;) {
    auto page = store.scan(shard, *from, kTilesAtOnce);
    if (!page) return pass_on(page);
    if (page->empty()) return {};
    from = TileKey::from_morton(page->back().key.morton() + 1);  // The last key there can be ends.
    if (auto ok = visit(*page); !ok) return ok;
  }
  return {};
}

/// The journal, its positions counted anew from 1, and the marks.
static Status copy_journal(RadosStore& from, RocksDbStore& to, ShardId shard, Epoch epoch) {
  std::vector<Bytes> records;
  const auto write = [&]() -> Status {
    if (auto ok = to.append(shard, epoch, records); !ok) return pass_on(ok);
    records.clear();
    return {};
  };
  auto copied = from.replay(shard, [&](JournalPosition, ByteView record) -> Status {
    records.emplace_back(record.begin(), record.end());
    return records.size() < kRecordsAtOnce ? Status() : write();
  });
  if (copied) copied = write();
  if (!copied) return copied;
  auto marks = from.marks(shard);
  if (!marks) return pass_on(marks);
  return to.trim(shard, epoch, 0, *marks);
}

static Status copy_shard(RadosStore& from, RocksDbStore& to, ShardId shard,
                         const std::vector<std::string>& names) {
  auto epoch = to.acquire(shard);
  if (!epoch) return pass_on(epoch);
  for (const auto& name : names) {
    auto value = from.value(shard, name);
    if (!value) return pass_on(value);
    if (!*value) continue;
    if (auto ok = to.put_value(shard, *epoch, name, **value); !ok) return ok;
  }
  if (auto ok = copy_journal(from, to, shard, *epoch); !ok) return ok;
  return for_each_page(from, shard, [&](const auto& page) { return to.put(shard, *epoch, page); });
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
    if (auto ok = copy_shard(*this, **copy, shard, *names); !ok) return ok;
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

Result<std::uint64_t> RadosStore::disk_bytes() {
  auto shards = all_shards(state_->pool);
  if (!shards) return pass_on(shards);
  std::uint64_t bytes = 0;
  for (const auto shard : *shards) {
    auto counted = for_each_page(*this, shard, [&](const auto& page) -> Status {
      for (const auto& tile : page) bytes += tile.bytes.size();
      return {};
    });
    if (counted) {
      counted = replay(shard, [&](JournalPosition, ByteView record) -> Status {
        bytes += record.size();
        return {};
      });
    }
    if (!counted) return pass_on(counted);
  }
  return bytes;
}

}  // namespace voxatlas
