#include "store/rados_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>

#include "grid/region_key.hpp"
#include "store/rados_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

static std::string number_text(std::uint64_t number) {
  Bytes bytes;
  ByteWriter(bytes).put(number);
  return {bytes.begin(), bytes.end()};
}

static std::string in_words(const RadosOptions& options) {
  return fmt::format("pool {}, model {}", options.pool, options.model);
}

RadosStore::RadosStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
RadosStore::~RadosStore() = default;

Result<std::unique_ptr<RadosStore>> RadosStore::open(const RadosOptions& options) {
  auto state = std::make_unique<State>();
  state->options = options;
  const auto refused = [&](int code, const std::string& what) {
    // A cluster that does not answer may be there again later; the others want another word.
    return fail(code == -ETIMEDOUT ? ErrorCode::kIo : ErrorCode::kUnavailable,
                fmt::format("{}: {}", what, std::generic_category().message(-code)));
  };
  // librados writes to connections that the cluster has closed: seen to end a process that had been
  // stopped for ten seconds.
  std::signal(SIGPIPE, SIG_IGN);
  if (int r = state->cluster.init2(options.client.c_str(), "ceph", 0); r < 0) {
    return refused(r, "librados");
  }
  if (int r = state->cluster.conf_read_file(options.conf.c_str()); r < 0) {
    return refused(r, options.conf);
  }
  // A connection that hangs while it is made is made anew after so many seconds; else 10, and a
  // take-over was once seen to last that.
  state->cluster.conf_set("ms_connection_ready_timeout", "3");
  state->cluster.conf_set("client_mount_timeout", "30");  // Seconds for connect(); else 300.
  if (int r = state->cluster.connect(); r < 0) return refused(r, "the cluster of " + options.conf);
  if (int r = state->cluster.ioctx_create(options.pool.c_str(), state->pool); r < 0) {
    return refused(r, "pool " + options.pool);
  }
  state->pool.set_namespace(options.model);
  return std::unique_ptr<RadosStore>(new RadosStore(std::move(state)));
}

Result<Epoch> RadosStore::acquire(ShardId id) {
  auto& shard = state_->slot(id);
  const std::lock_guard guard(shard.mutex);
  if (int r = state_->pool.create(shard_object(id), false); r < 0) {
    return tl::unexpected(state_->error_of(r, "making " + shard_object(id)));
  }
  if (!shard.lease || !shard.lease->fresh()) {  // Or it has gone to another since.
    shard.lease.reset();
    auto lease = RadosLease::take(state_->pool, shard_object(id));
    if (!lease) return pass_on(lease, in_words(state_->options));
    shard.lease = std::move(*lease);
  }
  for (;;) {  // Until nobody else came between.
    auto before = state_->stored_epoch(id);
    if (!before) return before;
    librados::ObjectWriteOperation operation;
    operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, *before);
    operation.setxattr(kEpochAttribute, buffer(std::to_string(*before + 1)));
    const int done = state_->pool.operate(shard_object(id), &operation);
    if (done == -ECANCELED) continue;
    if (done < 0) {
      auto failure = state_->failed(id, shard, done, "acquire");
      return pass_on(failure);
    }
    if (auto ok = state_->load(id, shard); !ok) return pass_on(ok);
    return *before + 1;
  }
}

Status RadosStore::put(ShardId id, Epoch epoch, std::span<const StoredTile> tiles) {
  auto owned = state_->own(id, epoch);
  if (!owned) return pass_on(owned);
  std::map<std::uint64_t, State::Rows> regions;
  std::set<std::uint64_t> wanted;
  for (const auto& tile : tiles) {
    const auto region = RegionKey::of(tile.key).code;
    const auto key = row_key(id, tile.key.morton());
    regions[region][key] = buffer(seal_tile(key, tile));
    wanted.insert(region);
  }
  if (auto ok = state_->make_regions(id, *owned->shard, wanted); !ok) return ok;
  return state_->write_regions(id, *owned->shard, std::move(regions));
}

Status RadosStore::trim(ShardId id, Epoch epoch, JournalPosition position,
                        std::span<const Mark> marks) {
  auto owned = state_->own(id, epoch);
  if (!owned) return pass_on(owned);
  auto& shard = *owned->shard;
  if (position > shard.last) return trim_beyond(id, position, shard.last);
  const auto trimmed = std::max(position, shard.trimmed);
  const auto marked = encode_marks(marks);
  const auto number = number_text(trimmed);
  State::Rows rows;
  rows[std::string(kMarksRow)] = buffer(seal(name_key(id, kMarksRow), marked));
  rows[std::string(kTrimmedRow)] = buffer(seal(name_key(id, kTrimmedRow), as_bytes(number)));
  librados::ObjectWriteOperation operation;
  operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, epoch);
  operation.omap_set(rows);
  std::set<std::string> gone;
  for (auto at = shard.trimmed + 1; at <= trimmed; ++at) gone.insert(numbered_row(kJournalRow, at));
  if (!gone.empty()) operation.omap_rm_keys(gone);
  if (auto ok = state_->write(id, shard, operation, "trim"); !ok) return ok;
  shard.trimmed = trimmed;
  return {};
}

Result<std::optional<StoredTile>> RadosStore::get(ShardId id, TileKey key) {
  const TileKey keys[] = {key};
  auto found = multi_get(id, keys);
  if (!found) return pass_on(found);
  return std::move(found->front());
}

Result<std::vector<std::optional<StoredTile>>> RadosStore::multi_get(
    ShardId id, std::span<const TileKey> keys) {
  std::map<std::uint64_t, std::set<std::string>> wanted;
  for (const auto key : keys) {
    wanted[RegionKey::of(key).code].insert(row_key(id, key.morton()));
  }
  auto tiles = state_->tiles_of(id, wanted);
  if (!tiles) return pass_on(tiles);
  std::vector<std::optional<StoredTile>> found;
  for (const auto key : keys) {
    const auto tile = tiles->find(row_key(id, key.morton()));
    found.push_back(tile == tiles->end() ? std::nullopt : std::optional(tile->second));
  }
  return found;
}

Result<std::vector<StoredTile>> RadosStore::scan(ShardId id, TileKey from, std::size_t limit) {
  std::vector<StoredTile> found;
  const auto first = RegionKey::of(from).code;
  // Keys after this one: those from the wanted one on.
  std::string after_tile = from.morton() == 0 ? "" : row_key(id, from.morton() - 1);
  std::string after_region =
      first == 0 ? std::string(kRegionRow) : numbered_row(kRegionRow, first - 1);
  while (found.size() < limit) {
    auto regions = state_->rows(shard_object(id), after_region, std::string(kRegionRow), 16);
    if (!regions) return pass_on(regions);
    if (regions->empty()) break;
    for (const auto& [row, value] : *regions) {
      auto region = number_of_row(kRegionRow, row);
      if (!region) return pass_on(region, shard_object(id));
      const auto object = region_object(id, *region);
      auto tiles = state_->rows(object, after_tile, "", limit - found.size());
      if (!tiles) return pass_on(tiles);
      for (auto& [key, sealed] : *tiles) {
        auto tile = unseal_tile(key, text_of(sealed));
        if (!tile) return pass_on(tile, object);
        found.push_back(std::move(*tile));
      }
      after_region = row;
      if (found.size() == limit) break;
    }
  }
  return found;
}

Status RadosStore::replay(ShardId id, const Visit& visit) {
  auto trimmed = state_->named_number(id, kTrimmedRow);
  if (!trimmed) return pass_on(trimmed);
  JournalPosition wanted = *trimmed;
  constexpr std::size_t kAtOnce = 64;
  for (;;) {
    auto page = state_->rows(shard_object(id), numbered_row(kJournalRow, wanted),
                             std::string(kJournalRow), kAtOnce);
    if (!page) return pass_on(page);
    for (auto& [row, value] : *page) {
      auto position = number_of_row(kJournalRow, row);
      if (!position) return pass_on(position, "journal");
      if (*position != ++wanted) {
        return fail(ErrorCode::kCorrupt, fmt::format("journal of shard {}: after {} comes {}", id,
                                                     wanted - 1, *position));
      }
      const auto sealed = text_of(value);
      auto record = unseal(name_key(id, row), sealed,
                           fmt::format("journal of shard {}, record {}", id, *position));
      if (!record) return pass_on(record);
      if (auto ok = visit(*position, *record); !ok) return ok;
    }
    if (page->size() < kAtOnce) return {};
  }
}

Result<std::vector<Mark>> RadosStore::marks(ShardId id) {
  auto bytes = state_->named(id, kMarksRow);
  if (!bytes) return pass_on(bytes);
  if (!*bytes) return std::vector<Mark>();
  return decode_marks(**bytes);
}

Status RadosStore::put_value(ShardId id, Epoch epoch, const std::string& name, ByteView value) {
  auto owned = state_->own(id, epoch);
  if (!owned) return pass_on(owned);
  const auto row = std::string(kValueRow) + name;
  librados::ObjectWriteOperation operation;
  operation.cmpxattr(kEpochAttribute, LIBRADOS_CMPXATTR_OP_EQ, epoch);
  operation.omap_set({{row, buffer(seal(name_key(id, row), value))}});
  return state_->write(id, *owned->shard, operation, "put_value");
}

Result<std::optional<Bytes>> RadosStore::value(ShardId id, const std::string& name) {
  return state_->named(id, std::string(kValueRow) + name);
}

}  // namespace voxatlas
