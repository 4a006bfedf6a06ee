#pragma once

#include <memory>
#include <string>
#include <vector>

#include "store/tile_store.hpp"

namespace voxatlas {

struct RadosOptions {
  std::string conf;                ///< The cluster's ceph.conf.
  std::string pool;                ///< Of replicated objects; it must exist.
  std::string model = "voxatlas";  ///< Name of the model within the pool: a RADOS namespace.
  std::string client = "client.admin";
};

/// A TileStore in a Ceph cluster, for a model that outgrows one disk or one machine.
///
/// Source:  DESIGN section 7; objects and rows in FORMAT.md. A shard is one object with its epoch,
///          marks, values and journal, and an object a region with its tiles; all rows are omap
///          rows, sealed as RocksDbStore's. Every write compares the epoch that stands on its
///          object, so a stale owner is fenced by the cluster itself.
/// Errors:  as TileStore says. put() over several regions is one write a region: where it fails
///          (kUnknown, kNoSpace) some may be there, each whole. open(): kUnavailable where there is
///          no such cluster or pool, kIo where it does not answer for half a minute. acquire():
///          kUnavailable names the live process that owns the shard, see RadosLease.
/// Threads: every call from any thread. Appends that wait for the same shard are written as one.
///          A replay must not meet a trim of its shard.
class RadosStore final : public TileStore {
 public:
  static Result<std::unique_ptr<RadosStore>> open(const RadosOptions& options);
  ~RadosStore() override;

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
  /// An embedded model: `directory` opens as a RocksDbStore. No write of this process comes
  /// between.
  Status checkpoint(const std::string& directory) override;
  Status verify(ShardId shard) override;
  /// What the tiles of the shards used here take, before replication: an estimate from eight
  /// regions of each, at most 10 s old, because all would be hours of reading.
  Result<std::uint64_t> disk_bytes() override;

 private:
  struct State;
  explicit RadosStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
