#include <fcntl.h>
#include <fmt/format.h>
#include <rocksdb/cache.h>
#include <rocksdb/filter_policy.h>
#include <rocksdb/table.h>
#include <rocksdb/write_buffer_manager.h>

#include <filesystem>

#include "base/log.hpp"
#include "store/rocksdb_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

/// In the default column family: which layout the other families have.
static constexpr std::string_view kFormatKey = "voxatlas store";
static constexpr std::uint32_t kFormat = 1;

static rocksdb::DBOptions db_options(const RocksDbOptions& options,
                                     const std::shared_ptr<rocksdb::Cache>& cache) {
  rocksdb::DBOptions db;
  db.create_if_missing = options.create;
  db.create_missing_column_families = options.create;
  db.paranoid_checks = true;
  // The default mode opens a log with a damaged middle as if it ended there.
  db.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  db.track_and_verify_wals_in_manifest = true;
  db.max_total_wal_size = options.max_wal_bytes;
  // What waits to be written is counted in the cache of what was read: one budget for both.
  db.write_buffer_manager =
      std::make_shared<rocksdb::WriteBufferManager>(options.write_buffer_bytes, cache);
  db.max_background_jobs = 2;
  db.max_open_files = 512;
  db.keep_log_file_num = 2;
  db.max_log_file_size = std::size_t{1} << 20;
  db.bytes_per_sync = std::uint64_t{1} << 20;
  return db;
}

static rocksdb::ColumnFamilyOptions family_options(const RocksDbOptions& options,
                                                   const std::shared_ptr<rocksdb::Cache>& cache,
                                                   std::size_t write_buffer_bytes) {
  rocksdb::BlockBasedTableOptions table;
  table.block_cache = cache;
  table.cache_index_and_filter_blocks = true;
  table.filter_policy.reset(rocksdb::NewBloomFilterPolicy(10));
  table.format_version = 5;
  rocksdb::ColumnFamilyOptions family;
  family.compression = rocksdb::kNoCompression;
  family.write_buffer_size = std::min(write_buffer_bytes, options.max_wal_bytes);
  family.level_compaction_dynamic_level_bytes = true;
  family.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
  return family;
}

rocksdb::ReadOptions checked_reads() {
  rocksdb::ReadOptions options;
  options.verify_checksums = true;
  return options;
}

Error RocksDbStore::State::error_of(const rocksdb::Status& status, std::string_view what) const {
  const std::string message = fmt::format("store {}: {}: {}", directory, what, status.ToString());
  if (status.IsNoSpace()) return {ErrorCode::kNoSpace, message};
  if (status.IsCorruption()) return {ErrorCode::kCorrupt, message};
  if (status.IsInvalidArgument()) return {ErrorCode::kInvalid, message};
  return {ErrorCode::kIo, message};
}

Error RocksDbStore::State::open_error(const rocksdb::Status& status) const {
  const std::string text = status.ToString();
  if (status.IsIOError() && text.find("lock ") != std::string::npos) {
    return {ErrorCode::kUnavailable,
            fmt::format("store {} is in use by another process: stop that one first ({})",
                        directory, text)};
  }
  if (text.find("does not exist (create_if_missing is false)") != std::string::npos) {
    return {ErrorCode::kNotFound, fmt::format("there is no store in {}", directory)};
  }
  return error_of(status, "opening");
}

/// A store says of itself that it is one; a new database is told so.
static Status check_format(rocksdb::DB& db, const std::string& directory) {
  std::string sealed;
  const auto status = db.Get(checked_reads(), slice(kFormatKey), &sealed);
  if (status.IsNotFound() && db.GetLatestSequenceNumber() == 0) {
    Bytes body;
    ByteWriter(body).put(kFormat);
    rocksdb::WriteOptions synced;
    synced.sync = true;
    const auto put = db.Put(synced, slice(kFormatKey), seal(kFormatKey, body));
    if (!put.ok()) return fail(ErrorCode::kIo, "store " + directory + ": " + put.ToString());
    return {};
  }
  if (status.IsNotFound()) return fail(ErrorCode::kCorrupt, directory + " is not a tile store");
  if (!status.ok()) return fail(ErrorCode::kCorrupt, directory + ": " + status.ToString());
  auto body = unseal(kFormatKey, sealed, directory + ": format");
  if (!body) return pass_on(body);
  ByteReader reader(*body);
  const auto format = reader.get<std::uint32_t>();
  if (!reader.at_end() || format != kFormat) {
    return fail(ErrorCode::kInvalid, fmt::format("store {} has format {}, this program knows {}",
                                                 directory, format, kFormat));
  }
  return {};
}

Status RocksDbStore::State::check_acked() {
  if (auto ok = acked.open(directory + "/ACKED"); !ok) return ok;
  const auto have = db->GetLatestSequenceNumber();
  if (have >= acked.sequence()) return {};
  return fail(ErrorCode::kCorrupt,
              fmt::format("store {} has lost acknowledged writes: its log ends at {}, {} was "
                          "acknowledged; a log or manifest file is damaged",
                          directory, have, acked.sequence()));
}

Status RocksDbStore::State::open_database(const RocksDbOptions& options) {
  const auto cache = rocksdb::NewLRUCache(options.memory_bytes);
  const auto large = family_options(options, cache, options.write_buffer_bytes / 2);
  const auto middle = family_options(options, cache, options.write_buffer_bytes / 4);
  const auto small = family_options(options, cache, options.write_buffer_bytes / 32);
  const std::vector<rocksdb::ColumnFamilyDescriptor> wanted = {
      {rocksdb::kDefaultColumnFamilyName, small},
      {"tiles", large},
      {"journal", middle},
      {"state", small}};
  rocksdb::DB* opened = nullptr;
  const auto status =
      rocksdb::DB::Open(db_options(options, cache), directory, wanted, &families, &opened);
  if (!status.ok()) return tl::unexpected(open_error(status));
  db.reset(opened);
  return {};
}

RocksDbStore::RocksDbStore(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<RocksDbStore>> RocksDbStore::open(const std::string& directory,
                                                         const RocksDbOptions& options) {
  std::error_code error;
  if (options.create) std::filesystem::create_directories(directory, error);
  if (error) {
    return fail(ErrorCode::kIo,
                fmt::format("cannot make the folder {}: {}", directory, error.message()));
  }
  auto state = std::make_unique<State>();
  state->directory = directory;
  state->sync = options.sync;
  state->reserve_bytes = options.reserve_bytes;
  auto& opened = *state;
  std::unique_ptr<RocksDbStore> store(new RocksDbStore(std::move(state)));
  if (auto ok = opened.open_database(options); !ok) return pass_on(ok);
  if (auto ok = opened.check_acked(); !ok) return pass_on(ok);
  if (auto ok = check_format(*opened.db, directory); !ok) return pass_on(ok);
  return store;
}

RocksDbStore::~RocksDbStore() {
  if (!state_->db) return;
  for (auto* family : state_->families) {
    const auto flushed = state_->db->Flush(rocksdb::FlushOptions(), family);
    if (!flushed.ok()) log_warning("{}", state_->error_of(flushed, "closing").message);
  }
  if (auto synced = state_->acked.sync(); !synced) log_warning("{}", synced.error().message);
  for (auto* family : state_->families) state_->db->DestroyColumnFamilyHandle(family);
  const auto closed = state_->db->Close();
  if (!closed.ok()) log_warning("{}", state_->error_of(closed, "closing").message);
}

}  // namespace voxatlas
