#include "tilestore/watched_store.hpp"

#include "base/utime.hpp"

namespace voxatlas {

/// A call under way, as long as it lives.
class WatchedStore::Call {
 public:
  explicit Call(WatchedStore& store) : store_(store) {
    const std::lock_guard guard(store_.mutex_);
    place_ = store_.calls_.insert(store_.calls_.end(), steady_utime());
  }
  ~Call() {
    const std::lock_guard guard(store_.mutex_);
    store_.calls_.erase(place_);
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

 private:
  WatchedStore& store_;
  std::list<std::int64_t>::iterator place_;
};

WatchedStore::WatchedStore(std::unique_ptr<TileStore> below) : below_(std::move(below)) {}

std::optional<std::int64_t> WatchedStore::waiting_since() const {
  const std::lock_guard guard(mutex_);
  if (calls_.empty()) return std::nullopt;
  return calls_.front();
}

Result<Epoch> WatchedStore::acquire(ShardId shard) {
  const Call call(*this);
  return below_->acquire(shard);
}

Result<JournalPosition> WatchedStore::append(ShardId shard, Epoch epoch,
                                             std::span<const Bytes> records) {
  const Call call(*this);
  return below_->append(shard, epoch, records);
}

Status WatchedStore::put(ShardId shard, Epoch epoch, std::span<const StoredTile> tiles) {
  const Call call(*this);
  return below_->put(shard, epoch, tiles);
}

Status WatchedStore::trim(ShardId shard, Epoch epoch, JournalPosition position,
                          std::span<const Mark> marks) {
  const Call call(*this);
  return below_->trim(shard, epoch, position, marks);
}

Result<std::optional<StoredTile>> WatchedStore::get(ShardId shard, TileKey key) {
  const Call call(*this);
  return below_->get(shard, key);
}

Result<std::vector<std::optional<StoredTile>>> WatchedStore::multi_get(
    ShardId shard, std::span<const TileKey> keys) {
  const Call call(*this);
  return below_->multi_get(shard, keys);
}

Result<std::vector<StoredTile>> WatchedStore::scan(ShardId shard, TileKey from, std::size_t limit) {
  const Call call(*this);
  return below_->scan(shard, from, limit);
}

Status WatchedStore::replay(ShardId shard, const Visit& visit) {
  return below_->replay(shard, visit);
}

Result<std::vector<Mark>> WatchedStore::marks(ShardId shard) {
  const Call call(*this);
  return below_->marks(shard);
}

Status WatchedStore::put_value(ShardId shard, Epoch epoch, const std::string& name,
                               ByteView value) {
  const Call call(*this);
  return below_->put_value(shard, epoch, name, value);
}

Result<std::optional<Bytes>> WatchedStore::value(ShardId shard, const std::string& name) {
  const Call call(*this);
  return below_->value(shard, name);
}

Status WatchedStore::checkpoint(const std::string& directory) {
  return below_->checkpoint(directory);
}

Status WatchedStore::verify(ShardId shard) { return below_->verify(shard); }

Result<std::uint64_t> WatchedStore::disk_bytes() {
  const Call call(*this);
  return below_->disk_bytes();
}

}  // namespace voxatlas
