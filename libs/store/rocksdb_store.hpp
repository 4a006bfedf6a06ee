#pragma once

#include <memory>
#include <string>
#include <vector>

#include "store/tile_store.hpp"

namespace voxatlas {

struct RocksDbOptions {
  /// False: writes are acknowledged before they are on the disk, and a power cut loses them. For
  /// the power-cut test alone, which must see that loss.
  bool sync = true;
  bool create = true;  ///< Make the folder and an empty store in it where there is none.
  /// All that RocksDB holds: blocks, indexes and filters read, and what is written and not yet in a
  /// file.
  std::size_t memory_bytes = std::size_t{48} << 20;
  std::size_t write_buffer_bytes = std::size_t{32} << 20;  ///< Of these, for what is written.
  /// Nothing is appended or put while the disk has less left than this: RocksDB itself must never
  /// meet a full disk, it aborts the process then.
  std::size_t reserve_bytes = std::size_t{64} << 20;
  std::size_t max_wal_bytes = std::size_t{64} << 20;  ///< RocksDB's own log, replayed on opening.
};

/// A TileStore in a folder, by RocksDB, embedded.
///
/// Source:  DESIGN section 7; rows and checksums in FORMAT.md. A plain LSM tree: no BlobDB, no
///          merge operator, no compression (tiles come compressed), every write synced.
/// Errors:  as TileStore says. A folder that another process has open, that is no store or that
///          has lost acknowledged writes is refused by open().
/// Threads: every call from any thread. Appends that wait for the same shard are written as one;
///          other writes of a shard wait for one another; several shards share RocksDB's group
///          commit.
class RocksDbStore final : public TileStore {
 public:
  static Result<std::unique_ptr<RocksDbStore>> open(const std::string& directory,
                                                    const RocksDbOptions& options = {});
  ~RocksDbStore() override;  ///< Flushes first, so that the next opening has no log to replay.

  Result<Epoch> acquire(ShardId shard) override;
  Result<JournalPosition> append(ShardId shard, Epoch epoch,
                                 std::span<const Bytes> records) override;
  Status put(ShardId shard, Epoch epoch, std::span<const StoredTile> tiles) override;
  Status trim(ShardId shard, Epoch epoch, JournalPosition position,
              std::span<const Mark> marks) override;
  Result<std::optional<StoredTile>> get(ShardId shard, TileKey key) override;
  Result<std::vector<std::optional<StoredTile>>> multi_get(ShardId shard,
                                                           std::span<const TileKey> keys) override;
  Result<std::vector<StoredTile>> scan(ShardId shard, TileKey from, std::size_t limit) override;
  Status replay(ShardId shard, const Visit& visit) override;
  Result<std::vector<Mark>> marks(ShardId shard) override;
  Status put_value(ShardId shard, Epoch epoch, const std::string& name, ByteView value) override;
  Result<std::optional<Bytes>> value(ShardId shard, const std::string& name) override;
  Status checkpoint(const std::string& directory) override;
  Status verify(ShardId shard) override;
  Result<std::uint64_t> disk_bytes() override;

  /// Rewrites all files without what was overwritten or trimmed.
  Status compact();

 private:
  struct State;
  explicit RocksDbStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
