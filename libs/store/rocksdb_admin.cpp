// What is asked of a store as a whole: copies, checks, sizes.
#include <fmt/format.h>
#include <rocksdb/utilities/checkpoint.h>

#include <filesystem>

#include "store/rocksdb_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

Status RocksDbStore::checkpoint(const std::string& directory) {
  rocksdb::Checkpoint* made = nullptr;
  auto status = rocksdb::Checkpoint::Create(state_->db.get(), &made);
  const std::unique_ptr<rocksdb::Checkpoint> checkpoint(made);
  if (status.ok()) status = checkpoint->CreateCheckpoint(directory);
  if (!status.ok()) return tl::unexpected(state_->error_of(status, "checkpoint to " + directory));
  return {};
}

Status RocksDbStore::State::verify_tiles(ShardId shard) {
  const std::string prefix = shard_prefix(shard);
  const std::unique_ptr<rocksdb::Iterator> row(db->NewIterator(checked_reads(), tiles()));
  for (row->Seek(prefix); row->Valid() && row->key().starts_with(prefix); row->Next()) {
    auto tile = unseal_tile(view(row->key()), view(row->value()));
    if (!tile) return pass_on(tile, "store " + directory);
  }
  if (!row->status().ok()) return tl::unexpected(error_of(row->status(), "verifying tiles"));
  return {};
}

Status RocksDbStore::State::verify_names(ShardId shard) {
  const std::string prefix = shard_prefix(shard);
  const std::unique_ptr<rocksdb::Iterator> row(db->NewIterator(checked_reads(), names()));
  for (row->Seek(prefix); row->Valid() && row->key().starts_with(prefix); row->Next()) {
    const auto what = fmt::format("store {}: state \"{}\" of shard {}", directory,
                                  view(row->key()).substr(prefix.size()), shard);
    if (auto body = unseal(view(row->key()), view(row->value()), what); !body) return pass_on(body);
  }
  if (!row->status().ok()) return tl::unexpected(error_of(row->status(), "verifying state"));
  return {};
}

Status RocksDbStore::verify(ShardId shard) {
  const auto files = state_->db->VerifyChecksum(checked_reads());
  if (!files.ok()) return tl::unexpected(state_->error_of(files, "verifying files"));
  if (auto ok = state_->verify_tiles(shard); !ok) return ok;
  if (auto ok = state_->verify_names(shard); !ok) return ok;
  if (auto ok = marks(shard); !ok) return pass_on(ok);
  return replay(shard, [](JournalPosition, ByteView) -> Status { return {}; });
}

Result<std::uint64_t> RocksDbStore::disk_bytes() {
  std::error_code error;
  std::uint64_t bytes = 0;
  std::filesystem::directory_iterator entry(state_->directory, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::error_code gone;  // RocksDB deletes files at any time.
    const auto size = entry->file_size(gone);
    if (!gone) bytes += size;
  }
  if (error) {
    return fail(ErrorCode::kIo,
                fmt::format("store {}: cannot list it: {}", state_->directory, error.message()));
  }
  return bytes;
}

Status RocksDbStore::compact() {
  rocksdb::CompactRangeOptions options;
  options.bottommost_level_compaction = rocksdb::BottommostLevelCompaction::kForce;
  for (auto* family : state_->families) {
    const auto status = state_->db->CompactRange(options, family, nullptr, nullptr);
    if (!status.ok()) return tl::unexpected(state_->error_of(status, "compact"));
  }
  return {};
}

}  // namespace voxatlas
