// What a shard remembers of itself between calls, and the one way its rows are written.
#include <fmt/format.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <cstring>

#include "store/rocksdb_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

RocksDbStore::State::Shard& RocksDbStore::State::slot(ShardId id) {
  const std::lock_guard guard(shards_mutex);
  auto& entry = shards[id];
  if (!entry) entry = std::make_unique<Shard>();
  return *entry;
}

Result<RocksDbStore::State::Owned> RocksDbStore::State::lock(ShardId id) {
  auto& shard = slot(id);
  Owned owned{std::unique_lock(shard.mutex), &shard};
  if (!shard.loaded) {
    if (auto ok = load(id, shard); !ok) return pass_on(ok);
  }
  return owned;
}

Result<RocksDbStore::State::Owned> RocksDbStore::State::own(ShardId id, Epoch epoch) {
  auto owned = lock(id);
  if (!owned) return owned;
  if (owned->shard->epoch != epoch) return fenced(id, epoch, owned->shard->epoch);
  return owned;
}

Status RocksDbStore::State::load(ShardId id, Shard& shard) {
  auto epoch = named_number(id, kEpochName);
  if (!epoch) return pass_on(epoch);
  auto trimmed = named_number(id, kTrimmedName);
  if (!trimmed) return pass_on(trimmed);
  auto last = last_position(id, *trimmed);
  if (!last) return pass_on(last);
  shard.epoch = *epoch;
  shard.trimmed = *trimmed;
  shard.last = *last;
  shard.loaded = true;
  return {};
}

/// The position of the journal's last row, or of the last trimmed one where there is none.
Result<JournalPosition> RocksDbStore::State::last_position(ShardId shard, JournalPosition trimmed) {
  const std::string prefix = shard_prefix(shard);
  const std::unique_ptr<rocksdb::Iterator> row(db->NewIterator(checked_reads(), journal()));
  row->SeekForPrev(row_key(shard, ~std::uint64_t{0}));
  if (!row->status().ok()) return tl::unexpected(error_of(row->status(), "journal"));
  if (!row->Valid() || !row->key().starts_with(prefix)) return trimmed;
  auto position = row_number(view(row->key()));
  if (!position) return pass_on(position, "journal");
  return std::max(trimmed, *position);
}

Status RocksDbStore::State::check_room(const rocksdb::WriteBatch& batch,
                                       std::string_view what) const {
  struct statvfs disk {};
  if (::statvfs(directory.c_str(), &disk) != 0) {
    return fail(ErrorCode::kIo, fmt::format("store {}: {}: how full the disk is: {}", directory,
                                            what, std::strerror(errno)));
  }
  const std::uint64_t left = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  const std::uint64_t wanted = batch.GetDataSize() + reserve_bytes;
  if (left >= wanted) return {};
  return fail(ErrorCode::kNoSpace,
              fmt::format("store {}: {}: the disk has {} bytes left, {} are wanted", directory,
                          what, left, wanted));
}

Status RocksDbStore::State::write(Shard& shard, rocksdb::WriteBatch& batch, std::string_view what) {
  if (out_of_space) {
    const auto resumed = db->Resume();
    if (!resumed.ok()) {
      return fail(ErrorCode::kNoSpace, fmt::format("store {}: {}: still no space: {}", directory,
                                                   what, resumed.ToString()));
    }
    out_of_space = false;
  }
  rocksdb::WriteOptions synced;
  synced.sync = sync;
  const auto status = db->Write(synced, &batch);
  if (status.ok()) return acked.raise(db->GetLatestSequenceNumber());
  shard.loaded = false;
  Error error = error_of(status, what);
  if (error.code == ErrorCode::kNoSpace) out_of_space = true;
  // The log may have got the record before the disk refused: only a look at it can tell.
  if (error.code == ErrorCode::kIo) error.code = ErrorCode::kUnknown;
  return tl::unexpected(std::move(error));
}

Result<std::optional<Bytes>> RocksDbStore::State::named(const std::string& key,
                                                        const std::string& what) {
  std::string sealed;
  const auto status = db->Get(checked_reads(), names(), key, &sealed);
  if (status.IsNotFound()) return std::optional<Bytes>();
  if (!status.ok()) return tl::unexpected(error_of(status, what));
  auto body = unseal(key, sealed, fmt::format("store {}: {}", directory, what));
  if (!body) return pass_on(body);
  return std::optional<Bytes>(Bytes(body->begin(), body->end()));
}

/// A number of the shard, 0 where it was never written.
Result<std::uint64_t> RocksDbStore::State::named_number(ShardId shard, std::string_view name) {
  const auto what = fmt::format("shard {}'s state \"{}\"", shard, name);
  auto bytes = named(name_key(shard, name), what);
  if (!bytes) return pass_on(bytes);
  if (!*bytes) return 0;
  ByteReader reader(**bytes);
  const auto number = reader.get<std::uint64_t>();
  if (!reader.at_end()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("store {}: {} has {} bytes, not 8", directory, what, (*bytes)->size()));
  }
  return number;
}

Status RocksDbStore::State::put_named(rocksdb::WriteBatch& batch, const std::string& key,
                                      ByteView body) {
  const auto status = batch.Put(names(), key, seal(key, body));
  if (!status.ok()) return tl::unexpected(error_of(status, "preparing a write"));
  return {};
}

}  // namespace voxatlas
