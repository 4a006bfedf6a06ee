#include "store/memory_store.hpp"

#include <fmt/format.h>

#include "store/store_format.hpp"

namespace voxatlas {

static std::string injected_message(ErrorCode code) {
  return fmt::format("memory store: injected {}", name_of(code));
}

void MemoryStore::inject(FaultHook hook) {
  const std::lock_guard lock(mutex_);
  fault_ = std::move(hook);
}

/// Every write: the epoch is checked, the fault asked for, and the work done under one lock.
Status MemoryStore::change(StoreCall call, ShardId shard, Epoch epoch,
                           const std::function<Status(Shard&)>& work) {
  const std::lock_guard lock(mutex_);
  Shard& owned = shards_[shard];
  if (owned.epoch != epoch) return fenced(shard, epoch, owned.epoch);
  const auto fault = fault_ ? fault_(call) : std::nullopt;
  if (fault && !fault->applied) return fail(fault->code, injected_message(fault->code));
  auto done = work(owned);
  if (!done || !fault) return done;
  return fail(fault->code, injected_message(fault->code));
}

/// Asks for a fault in a read; the caller holds the lock.
Status MemoryStore::readable() {
  const auto fault = fault_ ? fault_(StoreCall::kRead) : std::nullopt;
  if (fault) return fail(fault->code, injected_message(fault->code));
  return {};
}

Result<Epoch> MemoryStore::acquire(ShardId shard) {
  const std::lock_guard lock(mutex_);
  const auto fault = fault_ ? fault_(StoreCall::kAcquire) : std::nullopt;
  if (fault && !fault->applied) return fail(fault->code, injected_message(fault->code));
  const Epoch epoch = ++shards_[shard].epoch;
  if (fault) return fail(fault->code, injected_message(fault->code));
  return epoch;
}

Result<JournalPosition> MemoryStore::append(ShardId shard, Epoch epoch,
                                            std::span<const Bytes> records) {
  JournalPosition last = 0;
  auto done = change(StoreCall::kAppend, shard, epoch, [&](Shard& owned) -> Status {
    for (const auto& record : records) owned.journal.emplace(++owned.last, record);
    last = owned.last;
    return {};
  });
  if (!done) return pass_on(done);
  return last;
}

Status MemoryStore::put(ShardId shard, Epoch epoch, std::span<const StoredTile> tiles) {
  return change(StoreCall::kPut, shard, epoch, [&](Shard& owned) -> Status {
    for (const auto& tile : tiles) owned.tiles.insert_or_assign(tile.key, tile);
    return {};
  });
}

Status MemoryStore::trim(ShardId shard, Epoch epoch, JournalPosition position,
                         std::span<const Mark> marks) {
  return change(StoreCall::kTrim, shard, epoch, [&](Shard& owned) -> Status {
    if (position > owned.last) return trim_beyond(shard, position, owned.last);
    owned.journal.erase(owned.journal.begin(), owned.journal.upper_bound(position));
    owned.marks.assign(marks.begin(), marks.end());
    return {};
  });
}

Result<std::optional<StoredTile>> MemoryStore::get(ShardId shard, TileKey key) {
  const TileKey keys[] = {key};
  auto found = multi_get(shard, keys);
  if (!found) return pass_on(found);
  return std::move(found->front());
}

Result<std::vector<std::optional<StoredTile>>> MemoryStore::multi_get(
    ShardId shard, std::span<const TileKey> keys) {
  const std::lock_guard lock(mutex_);
  if (auto ok = readable(); !ok) return pass_on(ok);
  const auto& tiles = shards_[shard].tiles;
  std::vector<std::optional<StoredTile>> found;
  found.reserve(keys.size());
  for (const auto key : keys) {
    const auto tile = tiles.find(key);
    found.push_back(tile == tiles.end() ? std::nullopt : std::optional(tile->second));
  }
  return found;
}

Result<std::vector<StoredTile>> MemoryStore::scan(ShardId shard, TileKey from, std::size_t limit) {
  const std::lock_guard lock(mutex_);
  if (auto ok = readable(); !ok) return pass_on(ok);
  const auto& tiles = shards_[shard].tiles;
  std::vector<StoredTile> found;
  for (auto tile = tiles.lower_bound(from); tile != tiles.end() && found.size() < limit; ++tile) {
    found.push_back(tile->second);
  }
  return found;
}

Status MemoryStore::replay(ShardId shard, const Visit& visit) {
  std::map<JournalPosition, Bytes> journal;
  {
    const std::lock_guard lock(mutex_);
    if (auto ok = readable(); !ok) return ok;
    journal = shards_[shard].journal;
  }
  for (const auto& [position, record] : journal) {
    if (auto ok = visit(position, record); !ok) return ok;
  }
  return {};
}

Result<std::vector<Mark>> MemoryStore::marks(ShardId shard) {
  const std::lock_guard lock(mutex_);
  if (auto ok = readable(); !ok) return pass_on(ok);
  return shards_[shard].marks;
}

Status MemoryStore::put_value(ShardId shard, Epoch epoch, const std::string& name, ByteView value) {
  return change(StoreCall::kPutValue, shard, epoch, [&](Shard& owned) -> Status {
    owned.values.insert_or_assign(name, Bytes(value.begin(), value.end()));
    return {};
  });
}

Result<std::optional<Bytes>> MemoryStore::value(ShardId shard, const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (auto ok = readable(); !ok) return pass_on(ok);
  const auto& values = shards_[shard].values;
  const auto found = values.find(name);
  if (found == values.end()) return std::optional<Bytes>();
  return std::optional(found->second);
}

Status MemoryStore::verify(ShardId) {
  const std::lock_guard lock(mutex_);
  return readable();
}

Result<std::uint64_t> MemoryStore::disk_bytes() {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& [id, shard] : shards_) {
    for (const auto& [key, tile] : shard.tiles) bytes += sizeof tile + tile.bytes.size();
    for (const auto& [position, record] : shard.journal) bytes += sizeof position + record.size();
  }
  return bytes;
}

}  // namespace voxatlas
