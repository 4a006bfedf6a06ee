#pragma once

#include <rocksdb/db.h>
#include <rocksdb/write_batch.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "store/acked_file.hpp"
#include "store/append_queue.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas {

/// What a RocksDbStore holds. For its own .cpp files: RocksDB's headers stay behind them.
struct RocksDbStore::State {
  struct Shard {
    AppendQueue appends;

    std::mutex mutex;  // Held for a whole write; guards what follows.
    bool loaded = false;
    Epoch epoch = 0;
    JournalPosition trimmed = 0;
    JournalPosition last = 0;
  };

  /// A shard held for writing, its epoch checked.
  struct Owned {
    std::unique_lock<std::mutex> lock;
    Shard* shard;
  };

  std::string directory;
  std::unique_ptr<rocksdb::DB> db;
  std::vector<rocksdb::ColumnFamilyHandle*> families;  // As opened: default, tiles, journal, state.
  AckedFile acked;
  bool sync = true;
  std::size_t reserve_bytes = 0;
  std::atomic<bool> out_of_space = false;  // A write failed so; RocksDB must be told to resume.

  std::mutex shards_mutex;
  std::map<ShardId, std::unique_ptr<Shard>> shards;  // Guarded by shards_mutex.

  rocksdb::ColumnFamilyHandle* tiles() const { return families[1]; }
  rocksdb::ColumnFamilyHandle* journal() const { return families[2]; }
  rocksdb::ColumnFamilyHandle* names() const { return families[3]; }

  Status open_database(const RocksDbOptions& options);
  /// Compares the database with the number of the last acknowledged write.
  Status check_acked();
  /// Of a failed opening; the common ones in words that say what to do.
  Error open_error(const rocksdb::Status& status) const;

  Shard& slot(ShardId shard);
  /// The shard, locked and read from disk where it was not. Then, by own(), its epoch is compared.
  Result<Owned> lock(ShardId shard);
  Result<Owned> own(ShardId shard, Epoch epoch);
  Status load(ShardId id, Shard& shard);
  /// Writes the records of all whose epoch is the shard's, in one batch; sets everyone's result.
  void append_group(ShardId shard, std::span<AppendQueue::Appending* const> group);
  Status append_rows(ShardId id, Shard& shard, std::span<AppendQueue::Appending* const> group);
  Result<JournalPosition> last_position(ShardId shard, JournalPosition trimmed);

  /// kNoSpace where the disk has less left than the batch and the reserve.
  Status check_room(const rocksdb::WriteBatch& batch, std::string_view what) const;
  /// Synced; where it fails the shard is read from disk again before its next write.
  Status write(Shard& shard, rocksdb::WriteBatch& batch, std::string_view what);
  Error error_of(const rocksdb::Status& status, std::string_view what) const;

  Result<std::optional<Bytes>> named(const std::string& key, const std::string& what);
  Result<std::uint64_t> named_number(ShardId shard, std::string_view name);
  Status put_named(rocksdb::WriteBatch& batch, const std::string& key, ByteView body);

  Status verify_tiles(ShardId shard);
  Status verify_names(ShardId shard);
};

// Names in the column family `state`; a value of the caller has kValuePrefix before its name.
inline constexpr std::string_view kEpochName = "e";
inline constexpr std::string_view kTrimmedName = "t";
inline constexpr std::string_view kMarksName = "m";
inline constexpr std::string_view kValuePrefix = "v/";

rocksdb::ReadOptions checked_reads();

inline rocksdb::Slice slice(std::string_view text) { return {text.data(), text.size()}; }
inline std::string_view view(const rocksdb::Slice& slice) { return {slice.data(), slice.size()}; }

}  // namespace voxatlas
