#include "store/rocksdb_store.hpp"

#include <fmt/format.h>
#include <rocksdb/utilities/checkpoint.h>

#include <filesystem>

#include "store/rocksdb_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

static Bytes number_bytes(std::uint64_t number) {
  Bytes bytes;
  ByteWriter(bytes).put(number);
  return bytes;
}

Result<Epoch> RocksDbStore::acquire(ShardId shard) {
  auto owned = state_->lock(shard);
  if (!owned) return pass_on(owned);
  const Epoch epoch = owned->shard->epoch + 1;
  rocksdb::WriteBatch batch;
  auto put = state_->put_named(batch, name_key(shard, kEpochName), number_bytes(epoch));
  if (!put) return pass_on(put);
  if (auto ok = state_->write(*owned->shard, batch, "acquire"); !ok) return pass_on(ok);
  owned->shard->epoch = epoch;
  return epoch;
}

Status RocksDbStore::put(ShardId shard, Epoch epoch, std::span<const StoredTile> tiles) {
  auto owned = state_->own(shard, epoch);
  if (!owned) return pass_on(owned);
  if (tiles.empty()) return {};
  rocksdb::WriteBatch batch;
  for (const auto& tile : tiles) {
    const std::string key = row_key(shard, tile.key.morton());
    const auto status = batch.Put(state_->tiles(), key, seal_tile(key, tile));
    if (!status.ok()) return tl::unexpected(state_->error_of(status, "put"));
  }
  if (auto ok = state_->check_room(batch, "put"); !ok) return ok;
  return state_->write(*owned->shard, batch, "put");
}

Status RocksDbStore::trim(ShardId shard, Epoch epoch, JournalPosition position,
                          std::span<const Mark> marks) {
  auto owned = state_->own(shard, epoch);
  if (!owned) return pass_on(owned);
  if (position > owned->shard->last) return trim_beyond(shard, position, owned->shard->last);
  const auto trimmed = std::max(position, owned->shard->trimmed);
  rocksdb::WriteBatch batch;
  if (auto ok = state_->put_named(batch, name_key(shard, kMarksName), encode_marks(marks)); !ok) {
    return ok;
  }
  if (trimmed > owned->shard->trimmed) {
    const auto status =
        batch.DeleteRange(state_->journal(), row_key(shard, 0), row_key(shard, trimmed + 1));
    if (!status.ok()) return tl::unexpected(state_->error_of(status, "trim"));
    auto put = state_->put_named(batch, name_key(shard, kTrimmedName), number_bytes(trimmed));
    if (!put) return put;
  }
  if (auto ok = state_->write(*owned->shard, batch, "trim"); !ok) return ok;
  owned->shard->trimmed = trimmed;
  return {};
}

Result<std::optional<StoredTile>> RocksDbStore::get(ShardId shard, TileKey key) {
  const TileKey keys[] = {key};
  auto found = multi_get(shard, keys);
  if (!found) return pass_on(found);
  return std::move(found->front());
}

Result<std::vector<std::optional<StoredTile>>> RocksDbStore::multi_get(
    ShardId shard, std::span<const TileKey> keys) {
  std::vector<std::string> rows;
  rows.reserve(keys.size());
  for (const auto key : keys) rows.push_back(row_key(shard, key.morton()));
  const std::vector<rocksdb::Slice> slices(rows.begin(), rows.end());
  std::vector<rocksdb::PinnableSlice> values(keys.size());
  std::vector<rocksdb::Status> statuses(keys.size());
  state_->db->MultiGet(checked_reads(), state_->tiles(), keys.size(), slices.data(), values.data(),
                       statuses.data());
  std::vector<std::optional<StoredTile>> found(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (statuses[i].IsNotFound()) continue;
    if (!statuses[i].ok()) return tl::unexpected(state_->error_of(statuses[i], "reading a tile"));
    auto tile = unseal_tile(rows[i], view(values[i]));
    if (!tile) return pass_on(tile, "store " + state_->directory);
    found[i] = std::move(*tile);
  }
  return found;
}

Result<std::vector<StoredTile>> RocksDbStore::scan(ShardId shard, TileKey from, std::size_t limit) {
  const std::string prefix = shard_prefix(shard);
  const std::unique_ptr<rocksdb::Iterator> row(
      state_->db->NewIterator(checked_reads(), state_->tiles()));
  std::vector<StoredTile> found;
  row->Seek(row_key(shard, from.morton()));
  for (; found.size() < limit && row->Valid() && row->key().starts_with(prefix); row->Next()) {
    auto tile = unseal_tile(view(row->key()), view(row->value()));
    if (!tile) return pass_on(tile, "store " + state_->directory);
    found.push_back(std::move(*tile));
  }
  if (!row->status().ok()) return tl::unexpected(state_->error_of(row->status(), "scan"));
  return found;
}

Status RocksDbStore::replay(ShardId shard, const Visit& visit) {
  const std::string prefix = shard_prefix(shard);
  JournalPosition wanted = 0;
  std::unique_ptr<rocksdb::Iterator> row;
  {  // The iterator's snapshot and the trimmed position belong together.
    auto owned = state_->lock(shard);
    if (!owned) return pass_on(owned);
    wanted = owned->shard->trimmed;
    row.reset(state_->db->NewIterator(checked_reads(), state_->journal()));
  }
  for (row->Seek(row_key(shard, wanted + 1)); row->Valid() && row->key().starts_with(prefix);
       row->Next()) {
    auto position = row_number(view(row->key()));
    if (!position) return pass_on(position, "journal");
    if (*position != ++wanted) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("store {}: journal of shard {}: after {} comes {}", state_->directory,
                              shard, wanted - 1, *position));
    }
    auto record = unseal(view(row->key()), view(row->value()),
                         fmt::format("store {}: journal of shard {}, record {}", state_->directory,
                                     shard, *position));
    if (!record) return pass_on(record);
    if (auto ok = visit(*position, *record); !ok) return ok;
  }
  if (!row->status().ok()) return tl::unexpected(state_->error_of(row->status(), "replay"));
  return {};
}

Result<std::vector<Mark>> RocksDbStore::marks(ShardId shard) {
  auto bytes = state_->named(name_key(shard, kMarksName), fmt::format("marks of shard {}", shard));
  if (!bytes) return pass_on(bytes);
  if (!*bytes) return std::vector<Mark>();
  return decode_marks(**bytes);
}

Status RocksDbStore::put_value(ShardId shard, Epoch epoch, const std::string& name,
                               ByteView value) {
  auto owned = state_->own(shard, epoch);
  if (!owned) return pass_on(owned);
  rocksdb::WriteBatch batch;
  const auto key = name_key(shard, std::string(kValuePrefix) + name);
  if (auto ok = state_->put_named(batch, key, value); !ok) return ok;
  return state_->write(*owned->shard, batch, "put_value");
}

Result<std::optional<Bytes>> RocksDbStore::value(ShardId shard, const std::string& name) {
  return state_->named(name_key(shard, std::string(kValuePrefix) + name),
                       fmt::format("value \"{}\" of shard {}", name, shard));
}

}  // namespace voxatlas
