#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/tile_key.hpp"

namespace voxatlas {

/// A tile as it rests: bytes of libs/codec, or a tombstone (erased: no bytes, but its version
/// stays).
struct StoredTile {
  TileKey key;
  std::uint64_t version = 0;
  Bytes bytes;  ///< Empty: a tombstone.

  bool tombstone() const { return bytes.empty(); }
};

/// Up to which scan a source's session has been applied.
struct Mark {
  std::string source;
  std::int64_t session = 0;
  std::int64_t seq = -1;

  friend bool operator==(const Mark&, const Mark&) = default;
};

using ShardId = std::uint32_t;
using Epoch = std::uint64_t;
using JournalPosition = std::uint64_t;  ///< Of a record: 1, 2, 3, ... in the order of appending.

/// Durable bytes: a journal for each shard, tiles by key, and a few named values. No meaning of its
/// own.
///
/// Source:  DESIGN section 7: redo by version, as databases do it. The atlas above gives the
/// meaning. Errors:  kFenced (another owner has a newer epoch: stop), kNoSpace (nothing was
/// written), kCorrupt,
///          kUnknown (it may have happened: read back, then retry), kIo.
/// Threads: every call from any thread.
class TileStore {
 public:
  virtual ~TileStore() = default;

  /// Makes the caller the shard's one owner and returns its epoch; every earlier epoch is fenced.
  virtual Result<Epoch> acquire(ShardId shard) = 0;

  /// Appends records to the shard's journal, all or none, durable on return. Returns the last one's
  /// position.
  virtual Result<JournalPosition> append(ShardId shard, Epoch epoch,
                                         std::span<const Bytes> records) = 0;

  /// Writes tiles, each replacing an earlier version of the same key, all or none, durable on
  /// return.
  virtual Status put(ShardId shard, Epoch epoch, std::span<const StoredTile> tiles) = 0;

  /// Forgets the records up to and including `position` and replaces the shard's marks, in one
  /// step.
  virtual Status trim(ShardId shard, Epoch epoch, JournalPosition position,
                      std::span<const Mark> marks) = 0;

  virtual Result<std::optional<StoredTile>> get(ShardId shard, TileKey key) = 0;
  /// In the order of `keys`; nullopt for a key never written.
  virtual Result<std::vector<std::optional<StoredTile>>> multi_get(
      ShardId shard, std::span<const TileKey> keys) = 0;

  /// Up to `limit` tiles with key >= from, ascending, tombstones included.
  virtual Result<std::vector<StoredTile>> scan(ShardId shard, TileKey from, std::size_t limit) = 0;

  /// Every record after the last trim, in order. Errors: the visitor's stop the replay and come
  /// back.
  using Visit = std::function<Status(JournalPosition, ByteView)>;
  virtual Status replay(ShardId shard, const Visit& visit) = 0;

  virtual Result<std::vector<Mark>> marks(ShardId shard) = 0;

  /// Small named values of a shard, such as the model's parameters; durable on return.
  virtual Status put_value(ShardId shard, Epoch epoch, const std::string& name, ByteView value) = 0;
  virtual Result<std::optional<Bytes>> value(ShardId shard, const std::string& name) = 0;

  /// A consistent copy that opens as a store of its own. `directory` must not exist.
  virtual Status checkpoint(const std::string& directory) = 0;

  /// Reads everything and checks every checksum; the error names the first thing that is wrong.
  virtual Status verify(ShardId shard) = 0;

  /// Bytes on disk (of memory, for a store in memory).
  virtual Result<std::uint64_t> disk_bytes() = 0;
};

}  // namespace voxatlas
