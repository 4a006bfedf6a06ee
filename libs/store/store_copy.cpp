#include "store/store_copy.hpp"

#include <fmt/format.h>

namespace voxatlas {

static constexpr std::size_t kTilesAtOnce = 256;
static constexpr std::size_t kRecordBytesAtOnce = std::size_t{4} << 20;
static constexpr const char* kUnfinishedName = "unfinished copy";

Status for_each_page(TileStore& store, ShardId shard, const VisitPage& visit) {
  for (auto from = TileKey::from_morton(0); from;) {
    auto page = store.scan(shard, *from, kTilesAtOnce);
    if (!page) return pass_on(page);
    if (page->empty()) return {};
    from = TileKey::from_morton(page->back().key.morton() + 1);  // The last key there can be ends.
    if (auto ok = visit(*page); !ok) return ok;
  }
  return {};
}

namespace {

/// Adds pieces to a hash, each with its length, so that no two contents are one text.
class Digest {
 public:
  void add(std::uint64_t number) {
    Bytes bytes;
    ByteWriter(bytes).put(number);
    hash_.update(bytes);
  }
  void add(ByteView bytes) {
    add(bytes.size());
    hash_.update(bytes);
  }
  Sha256Digest finish() { return hash_.finish(); }

 private:
  Sha256 hash_;
};

Status add_names(TileStore& store, ShardId shard, const std::vector<std::string>& values,
                 Digest& digest) {
  auto marks = store.marks(shard);
  if (!marks) return pass_on(marks);
  digest.add(marks->size());
  for (const auto& mark : *marks) {
    digest.add(
        ByteView(reinterpret_cast<const std::uint8_t*>(mark.source.data()), mark.source.size()));
    digest.add(static_cast<std::uint64_t>(mark.session));
    digest.add(static_cast<std::uint64_t>(mark.seq));
  }
  for (const auto& name : values) {
    auto value = store.value(shard, name);
    if (!value) return pass_on(value);
    digest.add(value->has_value() ? 1 : 0);
    if (*value) digest.add(ByteView(**value));
  }
  return {};
}

/// What is not there yet of one page.
Result<std::vector<StoredTile>> missing_of(TileStore& to, ShardId shard,
                                           std::vector<StoredTile>& page) {
  std::vector<TileKey> keys;
  for (const auto& tile : page) keys.push_back(tile.key);
  auto there = to.multi_get(shard, keys);
  if (!there) return pass_on(there);
  std::vector<StoredTile> missing;
  for (std::size_t i = 0; i < page.size(); ++i) {
    const auto& found = (*there)[i];
    if (found && found->version > page[i].version) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("tile {:#x} has version {} in the copy and {} in the model: it is a "
                              "copy of something else",
                              page[i].key.morton(), found->version, page[i].version));
    }
    if (found && found->version == page[i].version && found->bytes == page[i].bytes) continue;
    missing.push_back(std::move(page[i]));
  }
  return missing;
}

/// An earlier call's records go first: how many of them there are says nothing of which.
Status copy_journal(TileStore& from, TileStore& to, ShardId shard, Epoch epoch) {
  auto marks = from.marks(shard);
  if (!marks) return pass_on(marks);
  JournalPosition last = 0;
  auto counted = to.replay(shard, [&](JournalPosition position, ByteView) -> Status {
    last = position;
    return {};
  });
  if (!counted) return counted;
  if (auto trimmed = to.trim(shard, epoch, last, *marks); !trimmed) return trimmed;
  std::vector<Bytes> records;
  std::size_t bytes = 0;
  const auto write = [&]() -> Status {
    if (records.empty()) return {};
    if (auto appended = to.append(shard, epoch, records); !appended) return pass_on(appended);
    records.clear();
    bytes = 0;
    return {};
  };
  auto copied = from.replay(shard, [&](JournalPosition, ByteView record) -> Status {
    records.emplace_back(record.begin(), record.end());
    bytes += record.size();
    return bytes < kRecordBytesAtOnce ? Status() : write();
  });
  return copied ? write() : copied;
}

Status copy_values(TileStore& from, TileStore& to, ShardId shard, Epoch epoch,
                   const std::vector<std::string>& values) {
  for (const auto& name : values) {
    auto value = from.value(shard, name);
    if (!value) return pass_on(value);
    if (!*value) continue;
    if (auto put = to.put_value(shard, epoch, name, **value); !put) return put;
  }
  return {};
}

}  // namespace

Result<ShardContent> shard_content(TileStore& store, ShardId shard,
                                   const std::vector<std::string>& values,
                                   const CopyProgress& progress) {
  ShardContent content;
  Digest digest;
  auto read = for_each_page(store, shard, [&](std::vector<StoredTile>& page) -> Status {
    if (auto on = progress(content.tiles); !on) return on;
    for (const auto& tile : page) {
      digest.add(tile.key.morton());
      digest.add(tile.version);
      digest.add(ByteView(tile.bytes));
    }
    content.tiles += page.size();
    return {};
  });
  if (!read) return pass_on(read);
  digest.add(content.tiles);
  read = store.replay(shard, [&](JournalPosition, ByteView record) -> Status {
    digest.add(record);
    ++content.records;
    return {};
  });
  if (!read) return pass_on(read);
  if (auto named = add_names(store, shard, values, digest); !named) return pass_on(named);
  content.digest = digest.finish();
  return content;
}

Result<ShardContent> copy_shard(TileStore& from, TileStore& to, ShardId shard, Epoch epoch,
                                const std::vector<std::string>& values,
                                const CopyProgress& progress) {
  std::uint64_t done = 0, written = 0;
  auto copied = for_each_page(from, shard, [&](std::vector<StoredTile>& page) -> Status {
    if (auto on = progress(done); !on) return on;
    done += page.size();
    auto missing = missing_of(to, shard, page);
    if (!missing) return pass_on(missing);
    written += missing->size();
    return missing->empty() ? Status() : to.put(shard, epoch, *missing);
  });
  if (copied) copied = copy_journal(from, to, shard, epoch);
  if (copied) copied = copy_values(from, to, shard, epoch, values);
  if (!copied) return pass_on(copied);
  auto wanted = shard_content(from, shard, values, progress);
  if (!wanted) return wanted;
  auto found = shard_content(to, shard, values, progress);
  if (!found) return found;
  if (found->digest != wanted->digest) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("the copy has {} tiles, {} records, SHA-256 {}; the model {}, {}, {}",
                            found->tiles, found->records, to_hex(found->digest), wanted->tiles,
                            wanted->records, to_hex(wanted->digest)));
  }
  found->written = written;
  return found;
}

Status mark_unfinished(TileStore& store, ShardId shard, Epoch epoch, bool unfinished) {
  const Bytes yes(1, 1);
  return store.put_value(shard, epoch, kUnfinishedName, unfinished ? ByteView(yes) : ByteView());
}

Result<bool> is_unfinished(TileStore& store, ShardId shard) {
  auto value = store.value(shard, kUnfinishedName);
  if (!value) return pass_on(value);
  return *value && !(*value)->empty();
}

}  // namespace voxatlas
