#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <optional>

#include "store/tile_store.hpp"

namespace voxatlas {

/// A TileStore that knows since when a call of it waits: a cluster or a disk that stands still
/// holds its caller, and somebody else must be able to say so.
///
/// Errors:  the store's below.
/// Threads: as the store below; waiting_since() from any.
class WatchedStore final : public TileStore {
 public:
  explicit WatchedStore(std::unique_ptr<TileStore> below);

  /// When the oldest call under way began, steady microseconds. checkpoint(), verify() and replay()
  /// do not count: they are long by themselves.
  std::optional<std::int64_t> waiting_since() const;

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

 private:
  class Call;

  std::unique_ptr<TileStore> below_;
  mutable std::mutex mutex_;
  std::list<std::int64_t> calls_;  // When each under way began, the oldest first; by mutex_.
};

}  // namespace voxatlas
