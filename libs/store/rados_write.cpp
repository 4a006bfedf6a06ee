// How a shard writes: every operation compares the epoch that stands on its object.
#include <fmt/format.h>

#include <cerrno>
#include <deque>

#include "store/rados_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

Status RadosStore::State::failed(ShardId id, Shard& shard, int code, std::string_view what) {
  const Epoch mine = shard.epoch;
  shard.loaded = false;
  if (code == -ECANCELED) {  // The comparison: another has taken the shard.
    auto owner = stored_epoch(id);
    return fenced(id, mine, owner ? *owner : 0);
  }
  Error error = error_of(code, what);
  if (error.code == ErrorCode::kIo) error.code = ErrorCode::kUnknown;
  return tl::unexpected(std::move(error));
}

Status RadosStore::State::write(ShardId id, Shard& shard, librados::ObjectWriteOperation& operation,
                                std::string_view what) {
  const int done = pool.operate(shard_object(id), &operation);
  return done < 0 ? failed(id, shard, done, what) : Status();
}

Result<JournalPosition> RadosStore::append(ShardId id, Epoch epoch,
                                           std::span<const Bytes> records) {
  return state_->slot(id).appends.append(
      epoch, records, [this, id](auto group) { state_->append_group(id, group); });
}

void RadosStore::State::append_group(ShardId id, std::span<AppendQueue::Appending* const> group) {
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

Status RadosStore::State::append_rows(ShardId id, Shard& shard,
                                      std::span<AppendQueue::Appending* const> group) {
  JournalPosition position = shard.last;
  Rows rows_of_all;
  for (auto* member : group) {
    if (member->epoch != shard.epoch) {
      member->result = fenced(id, member->epoch, shard.epoch);
      continue;
    }
    for (const auto& record : member->records) {
      const auto row = numbered_row(kJournalRow, ++position);
      rows_of_all[row] = buffer(seal(name_key(id, row), record));
    }
    member->result = position;
  }
  if (rows_of_all.empty()) return {};
  librados::ObjectWriteOperation operation;
  operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, shard.epoch);
  operation.omap_set(rows_of_all);
  if (auto ok = write(id, shard, operation, "append"); !ok) return ok;
  shard.last = position;
  return {};
}

/// First the object, then the place in the list: an object that no list names is empty, and made
/// again when it is wanted; one that is listed and not there could never be written to.
Status RadosStore::State::make_regions(ShardId id, Shard& shard,
                                       const std::set<std::uint64_t>& wanted) {
  Rows listed;
  for (const auto region : wanted) {
    const auto row = numbered_row(kRegionRow, region);
    if (!shard.regions.contains(region)) listed[row] = buffer(seal(name_key(id, row), {}));
  }
  if (listed.empty() && shard.lease && shard.lease->fresh()) return {};
  // Where all are there this asks the shard's object whether the epoch is still ours.
  librados::ObjectWriteOperation operation;
  operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, shard.epoch);
  if (listed.empty()) {
    librados::ObjectReadOperation look;
    look.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, shard.epoch);
    const int same = pool.operate(shard_object(id), &look, nullptr);
    return same < 0 ? failed(id, shard, same, "put") : Status();
  }
  for (const auto region : wanted) {
    if (shard.regions.contains(region)) continue;
    const int made = pool.create(region_object(id, region), false);
    if (made < 0) return failed(id, shard, made, "making a region");
  }
  operation.omap_set(listed);
  if (auto ok = write(id, shard, operation, "listing regions"); !ok) return ok;
  shard.regions.insert(wanted.begin(), wanted.end());
  return {};
}

/// All at once. A stale owner's write that comes before its successor's first one to the region is
/// let through: it holds what was journalled before, and the successor's recovery counts versions.
Status RadosStore::State::write_regions(ShardId id, Shard& shard,
                                        std::map<std::uint64_t, Rows> tiles) {
  std::deque<librados::ObjectWriteOperation> operations;
  std::deque<RadosCompletion> under_way;
  for (auto& [region, rows_of_region] : tiles) {
    auto& operation = operations.emplace_back();
    operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_GTE, shard.epoch);
    operation.setxattr(kEpochAttribute, buffer(std::to_string(shard.epoch)));
    operation.omap_set(rows_of_region);
    auto& one = under_way.emplace_back();
    const int begun = pool.aio_operate(region_object(id, region), one.completion, &operation);
    one.begun = begun >= 0;
    if (begun < 0) return failed(id, shard, begun, "put");
  }
  Status status;
  for (auto& one : under_way) {
    const int done = one.result();
    if (done < 0 && status) status = failed(id, shard, done, "put");
  }
  return status;
}

}  // namespace voxatlas
