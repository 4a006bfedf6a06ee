// Journal records of one shard: those who wait for the disk at the same time share one synced
// write.
#include <fmt/format.h>

#include "store/rocksdb_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

Result<JournalPosition> RocksDbStore::append(ShardId id, Epoch epoch,
                                             std::span<const Bytes> records) {
  return state_->slot(id).appends.append(
      epoch, records, [this, id](auto group) { state_->append_group(id, group); });
}

void RocksDbStore::State::append_group(ShardId id, std::span<AppendQueue::Appending* const> group) {
  auto written = [&]() -> Status {
    auto owned = lock(id);
    if (!owned) return pass_on(owned);
    return append_rows(id, *owned->shard, group);
  }();
  if (written) return;
  for (auto* member : group) {
    if (member->result) member->result = tl::unexpected<Error>(written.error());
  }
}

Status RocksDbStore::State::append_rows(ShardId id, Shard& shard,
                                        std::span<AppendQueue::Appending* const> group) {
  JournalPosition position = shard.last;
  rocksdb::WriteBatch batch;
  for (auto* member : group) {
    if (member->epoch != shard.epoch) {
      member->result = fenced(id, member->epoch, shard.epoch);
      continue;
    }
    for (const auto& record : member->records) {
      const std::string key = row_key(id, ++position);
      const auto status = batch.Put(journal(), key, seal(key, record));
      if (!status.ok()) return tl::unexpected(error_of(status, "append"));
    }
    member->result = position;
  }
  if (position == shard.last) return {};
  if (auto ok = check_room(batch, "append"); !ok) return ok;
  if (auto ok = write(shard, batch, "append"); !ok) return ok;
  shard.last = position;
  return {};
}

}  // namespace voxatlas
