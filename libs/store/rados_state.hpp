#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <rados/librados.hpp>
#include <set>
#include <string>
#include <string_view>

#include "store/append_queue.hpp"
#include "store/rados_lease.hpp"
#include "store/rados_store.hpp"

namespace voxatlas {

/// What a RadosStore holds. For its own .cpp files: librados's headers stay behind them.
struct RadosStore::State {
  struct Shard {
    AppendQueue appends;

    std::mutex mutex;                   // Held for a whole write; guards what follows.
    std::unique_ptr<RadosLease> lease;  // From acquire() on.
    bool loaded = false;
    Epoch epoch = 0;
    JournalPosition trimmed = 0;
    JournalPosition last = 0;
    std::set<std::uint64_t> regions;  // Those that have an object and stand in the shard's list.
  };
  struct Owned {
    std::unique_lock<std::mutex> lock;
    Shard* shard;
  };
  using Rows = std::map<std::string, librados::bufferlist>;

  RadosOptions options;
  librados::Rados cluster;
  librados::IoCtx pool;  // Safe from any thread.

  std::mutex shards_mutex;
  std::map<ShardId, std::unique_ptr<Shard>> shards;  // Guarded by shards_mutex.

  std::mutex bytes_mutex;
  std::optional<std::uint64_t> total_bytes;  // disk_bytes' last answer; guarded by bytes_mutex.
  std::chrono::steady_clock::time_point total_at;  // Likewise.

  // rados_admin.cpp
  Result<std::uint64_t> estimate_bytes(ShardId id);
  Result<std::vector<std::string>> value_names(ShardId id);

  // rados_shard.cpp
  Shard& slot(ShardId id);
  /// The shard, locked and read from the cluster where it was not. Then, by own(), its epoch is
  /// compared.
  Result<Owned> lock(ShardId id);
  Result<Owned> own(ShardId id, Epoch epoch);
  Status load(ShardId id, Shard& shard);
  Result<Epoch> stored_epoch(ShardId id);
  Result<JournalPosition> last_position(ShardId id, JournalPosition trimmed);
  Result<std::optional<Bytes>> named(ShardId id, std::string_view name);
  /// Tiles by row key, of those wanted of each region; all regions are asked at once.
  Result<std::map<std::string, StoredTile>> tiles_of(
      ShardId id, const std::map<std::uint64_t, std::set<std::string>>& wanted);
  Result<std::uint64_t> named_number(ShardId id, std::string_view name);
  /// Up to `limit` rows of an object after `after` whose keys begin with `prefix`; none where there
  /// is no such object.
  Result<Rows> rows(const std::string& object, const std::string& after, const std::string& prefix,
                    std::size_t limit);

  // rados_write.cpp
  /// One operation on the shard's own object, done only if the epoch there is the shard's.
  Status write(ShardId id, Shard& shard, librados::ObjectWriteOperation& operation,
               std::string_view what);
  /// What a failed write means for the shard, which is read again before its next one.
  Status failed(ShardId id, Shard& shard, int code, std::string_view what);
  void append_group(ShardId id, std::span<AppendQueue::Appending* const> group);
  Status append_rows(ShardId id, Shard& shard, std::span<AppendQueue::Appending* const> group);
  /// Objects for those regions that have none, and their place in the shard's list.
  Status make_regions(ShardId id, Shard& shard, const std::set<std::uint64_t>& wanted);
  Status write_regions(ShardId id, Shard& shard, std::map<std::uint64_t, Rows> tiles);

  Error error_of(int code, std::string_view what) const;
};

/// An operation under way; whoever holds it waits for it.
class RadosCompletion {
 public:
  RadosCompletion() : completion(librados::Rados::aio_create_completion()) {}
  RadosCompletion(const RadosCompletion&) = delete;
  RadosCompletion& operator=(const RadosCompletion&) = delete;
  ~RadosCompletion() {
    if (begun) completion->wait_for_complete();
    completion->release();
  }
  int result() {
    completion->wait_for_complete();
    return completion->get_return_value();
  }
  librados::AioCompletion* completion;
  bool begun = false;
};

std::string shard_object(ShardId id);
std::string region_object(ShardId id, std::uint64_t region);

// Rows of a shard's object; the number in a journal's or a region's key is 8 bytes, big endian.
inline constexpr std::string_view kTrimmedRow = "t";
inline constexpr std::string_view kMarksRow = "m";
inline constexpr std::string_view kValueRow = "v/";
inline constexpr std::string_view kJournalRow = "j/";
inline constexpr std::string_view kRegionRow = "r/";
inline constexpr const char* kEpochAttribute = "epoch";

std::string numbered_row(std::string_view prefix, std::uint64_t number);
Result<std::uint64_t> number_of_row(std::string_view prefix, std::string_view row);

librados::bufferlist buffer(std::string_view text);
std::string text_of(librados::bufferlist& buffer);

}  // namespace voxatlas
