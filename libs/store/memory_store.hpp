#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "store/tile_store.hpp"

namespace voxatlas {

/// The calls a fault can be injected into.
enum class StoreCall { kAcquire, kAppend, kPut, kTrim, kPutValue, kRead };

/// What an injected call returns, and whether it did its work all the same (as kUnknown may).
struct StoreFault {
  ErrorCode code = ErrorCode::kUnknown;
  bool applied = false;
};

/// A TileStore in plain maps: the oracle of the contract test, and a store that can be told to
/// fail. Nothing in it outlives the process but a checkpoint.
///
/// Threads: every call from any thread; one mutex, no speed.
class MemoryStore final : public TileStore {
 public:
  MemoryStore() = default;
  /// What checkpoint() wrote. Errors: kIo, kCorrupt.
  static Result<std::unique_ptr<MemoryStore>> load(const std::string& directory);

  /// Asked before every call from now on; a fault it gives is what the call returns. Called with
  /// the store locked: it must not call back. An empty function ends it.
  using FaultHook = std::function<std::optional<StoreFault>(StoreCall)>;
  void inject(FaultHook hook);

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
  struct Shard {
    Epoch epoch = 0;
    JournalPosition last = 0;  ///< Position of the last record ever appended.
    std::map<JournalPosition, Bytes> journal;
    std::map<TileKey, StoredTile> tiles;
    std::vector<Mark> marks;
    std::map<std::string, Bytes> values;
  };

  Status change(StoreCall call, ShardId shard, Epoch epoch,
                const std::function<Status(Shard&)>& work);
  Status readable();
  static void write(const Shard& shard, Bytes& out);
  static Result<Shard> read(ByteView bytes);

  std::mutex mutex_;
  std::map<ShardId, Shard> shards_;  // Guarded by mutex_.
  FaultHook fault_;                  // Guarded by mutex_.
};

}  // namespace voxatlas
