#include "render/tree_cache.hpp"

#include <algorithm>
#include <utility>

#include "base/log.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kMostChanges = 256;  // Further ones: fetching the tile is cheaper.
constexpr std::int64_t kTrimEvery = 100'000;
/// A tile that came and is not new enough is not asked for again at once: whoever told of a newer
/// version may have been wrong.
constexpr std::int64_t kAskGap = 50'000;
/// A listing may overtake the changes that it knows of, which come by another way: for so long they
/// are not taken for lost.
constexpr std::int64_t kOvertaken = 200'000;
constexpr std::uint64_t kNeverWritten = ~std::uint64_t{0};

}  // namespace

void TreeCache::Tile::drop_source() {
  bytes.reset();
  live.reset();
  lost_track = lent;
  lent = false;
  changes.clear();
}

void TreeCache::take(ArrivedTile arrived, std::int64_t now) {
  Tile& tile = tiles_[arrived.key];
  if (tile.used_at == 0) tile.used_at = now;
  tile.ask_again_at = now + kAskGap;
  if (arrived.version == 0) {
    tile.broken = kNeverWritten;
    return;
  }
  if (arrived.depth < kDepth) {
    if (tile.tree || tile.has_source()) return;
    tile.coarse = std::make_shared<const Bytes>(std::move(arrived.bytes));
    tile.coarse_version = arrived.version;
    tile.ask_again_at = now;
    return count(tile);
  }
  if (tile.has_source() && arrived.version <= tile.reach) return;
  const std::uint64_t after =
      tile.reach > arrived.version ? tile.reach - arrived.version : 0;  // Changes still to apply.
  auto changes = std::exchange(tile.changes, {});
  tile.drop_source();
  tile.bytes = std::make_shared<const Bytes>(std::move(arrived.bytes));
  tile.reach = arrived.version;
  if (after > 0 && after <= changes.size()) {
    changes.erase(changes.begin(), changes.end() - static_cast<std::ptrdiff_t>(after));
    tile.changes = std::move(changes);
    tile.reach += after;
  }
  count(tile);
}

void TreeCache::update(Update update, bool watched, std::int64_t now) {
  auto found = tiles_.find(update.key);
  if (found == tiles_.end()) {
    if (!watched || update.version != 1) return;  // It is asked for when somebody looks.
    found = tiles_.try_emplace(update.key).first;
    found->second.live.emplace();
    found->second.used_at = now;
  }
  Tile& tile = found->second;
  if (update.version <= tile.reach || update.version <= tile.shown()) return;
  tile.lives = true;
  tile.changed_at = now;
  auto& since = tile.building ? tile.stale_next : tile.stale;
  if (since == Since{}) since = update.since;
  constexpr int kDelta = 1, kWhole = 2;
  if (update.content == kWhole) {
    return take(ArrivedTile{update.key, update.version, std::move(update.payload), kDepth}, now);
  }
  if (now - tile.used_at > kKeepLive) {  // Nobody looks: it is asked for when somebody does.
    tile.drop_source();
    tile.reach = 0;
    return count(tile);
  }
  const bool follows = update.version == tile.reach + 1 && tile.changes.size() < kMostChanges;
  if (!follows) tile.drop_source();  // One was lost, or there was none yet.
  if (update.content == kDelta) {
    tile.changes.push_back(std::move(update.payload));
    tile.reach = update.version;
  } else {
    tile.drop_source();
    tile.reach = 0;
  }
  count(tile);
}

void TreeCache::hear(TileKey key, std::uint64_t version, std::int64_t now) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) return;
  Tile& tile = found->second;
  if (version > tile.known() && tile.behind_since == 0) tile.behind_since = now;
}

TreeCache::Standing TreeCache::look(TileKey key, std::uint64_t newest, std::int64_t now,
                                    int free_depth) {
  Standing standing;
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) {
    standing.must_ask = true;
    standing.ask_depth = kCoarse;
    return standing;
  }
  Tile& tile = found->second;
  tile.used_at = now;
  settle(tile, now);
  if (free_depth > 0) {
    tile.free_wanted = free_depth;
    if (tile.free && tile.free->depth() == free_depth) standing.free = tile.free;
    if (!standing.free) tile.fine = false;  // Once more, with its free cells.
  }
  standing.tree = tile.tree;
  standing.stale = tile.stale;
  standing.fine = tile.fine;
  standing.serial = tile.serial;
  standing.complete = (tile.fine && tile.shown() >= newest) || tile.broken >= newest;
  standing.smooth = standing.complete && !tile.rough && !tile.building;
  standing.rough_at = tile.rough_at;
  if (tile.known() >= newest) tile.behind_since = 0;
  standing.behind_since = tile.behind_since;
  if (standing.complete || tile.building) return standing;
  const bool overtaken = tile.behind_since > 0 && now - tile.behind_since < kOvertaken;
  if (tile.has_source() && tile.reach < newest && !overtaken) {  // Changes were lost.
    tile.drop_source();
    count(tile);
  }
  standing.must_ask = !tile.has_source() && now >= tile.ask_again_at;
  if (!tile.tree && !tile.coarse && tile.broken == 0) standing.ask_depth = kCoarse;
  standing.must_build = tile.has_source() || (tile.coarse && !tile.tree);
  return standing;
}

std::optional<BuildJob> TreeCache::job(TileKey key, bool borders) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end()) return std::nullopt;
  Tile& tile = found->second;
  const bool news = tile.shown() < tile.reach || !tile.fine;
  if (tile.building) return std::nullopt;
  if (tile.rough && tile.fine && !(news && tile.has_source())) {
    return borders ? std::optional(border_job(key, tile)) : std::nullopt;
  }
  if (tile.coarse && !tile.tree) return coarse_job(key, tile);
  if (!tile.has_source() || !news) return std::nullopt;
  BuildJob job{key, tile.reach};
  job.keep = tile.lives;
  job.free_depth = tile.free_wanted;
  job.before = tile.tree;
  if (!tile.tree) job.depth = kCoarse;
  if (tile.live) {
    job.tile = std::move(tile.live);
    tile.live.reset();
  } else {
    job.bytes = tile.bytes;
  }
  job.changes = std::exchange(tile.changes, {});
  job.keep = job.keep || !job.changes.empty() || job.tile.has_value();
  if (job.keep) {
    tile.bytes.reset();
    tile.lent = true;
  }
  tile.building = true;
  tile.stale_next = {};
  count(tile);
  return job;
}

/// Calls visit(offset, index) for the 26 tiles around one, those beyond the grid's lower end too.
template <class Visit>
static void for_each_around(TileKey key, Visit visit) {
  const Index3 at = key.index();
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    Index3 index = at;
    for (std::size_t axis = 0; axis < 3; ++axis) {  // Below 0 it wraps round and is refused.
      index[axis] += static_cast<std::uint32_t>(offset[static_cast<Eigen::Index>(axis)]);
    }
    const auto around = TileKey::from_index(index);
    if (i != 13 && around) visit(offset, *around);
  }
}

BuildJob TreeCache::coarse_job(TileKey key, Tile& tile) {
  BuildJob job{key, tile.coarse_version};
  job.bytes = std::exchange(tile.coarse, nullptr);
  job.depth = kCoarse;
  tile.building = true;
  tile.stale_next = {};
  return job;
}

BuildJob TreeCache::border_job(TileKey key, Tile& tile) {
  BuildJob job{key, tile.shown()};
  job.middle = tile.tree;
  for_each_around(key, [&](const Eigen::Vector3i& offset, TileKey around) {
    const auto found = tiles_.find(around);
    if (found != tiles_.end() && found->second.fine) {
      job.around.emplace_back(offset, found->second.tree);
    }
  });
  tile.rough = false;
  tile.building = true;
  tile.stale_next = {};
  return job;
}

/// A tile and those around it.
void TreeCache::roughen(TileKey key, std::int64_t now) {
  const auto mark = [&](TileKey tile) {
    const auto found = tiles_.find(tile);
    if (found == tiles_.end()) return;
    found->second.rough = true;
    found->second.rough_at = now;
  };
  mark(key);
  for_each_around(key, [&](const Eigen::Vector3i&, TileKey around) { mark(around); });
}

void TreeCache::take(BuiltTile built, std::int64_t now) {
  const auto found = tiles_.find(built.key);
  if (found == tiles_.end()) return;  // Never: what is being built stays.
  Tile& tile = found->second;
  const bool kept_track = !std::exchange(tile.lost_track, false);
  tile.building = false;
  if (!built.sound) {
    ++broken_;
    log_warning("a tile is not drawn: {}", built.sound.error().message);
    if (built.no_tile) tile.broken = std::max(tile.broken, built.version);
    tile.drop_source();
    tile.lost_track = false;
    tile.reach = 0;
    return count(tile);
  }
  tile.serial = ++serials_;
  if (built.borders) {
    if (tile.stale == Since{}) tile.stale = tile.stale_next;
    tile.stale_next = {};
    tile.tree = std::move(built.tree);
    return count(tile);
  }
  const bool lent = std::exchange(tile.lent, false);
  if (kept_track && lent) {
    tile.live = std::move(built.tile);
    tile.live_bytes = built.tile_bytes;
  }
  tile.fine = built.depth == kDepth;
  tile.tree = std::move(built.tree);
  tile.free = std::move(built.free);
  if (tile.fine) {
    tile.stale = tile.stale_next;
    tile.stale_next = {};
    roughen(built.key, now);
  }
  settle(tile, now);
  count(tile);
}

/// A tile that has not changed for a while is not kept for its next change.
void TreeCache::settle(Tile& tile, std::int64_t now) {
  if (!tile.live || now - tile.changed_at < kKeepLive) return;
  if (!tile.fine || tile.shown() < tile.reach) return;
  tile.live.reset();
  tile.lives = false;
  count(tile);
}

void TreeCache::count(Tile& tile) {
  std::size_t bytes = sizeof(Tile);
  if (tile.tree) bytes += tile.tree->memory_bytes();
  if (tile.free) bytes += tile.free->memory_bytes();
  if (tile.live) bytes += tile.live_bytes;
  if (tile.bytes) bytes += tile.bytes->capacity();
  if (tile.coarse) bytes += tile.coarse->capacity();
  for (const Bytes& change : tile.changes) bytes += change.capacity();
  bytes_ += bytes - tile.counted;
  tile.counted = bytes;
  const std::size_t spare = tile.bytes && tile.rests() ? tile.bytes->capacity() : 0;
  spare_bytes_ += spare - tile.spare;
  tile.spare = spare;
}

void TreeCache::drop_spare() {
  for (auto& [key, tile] : tiles_) {
    if (tile.spare == 0) continue;
    tile.bytes.reset();
    count(tile);
  }
}

void TreeCache::trim(std::int64_t now) {
  if (bytes_ <= budget_ || now - trimmed_at_ < kTrimEvery) return;
  trimmed_at_ = now;
  drop_spare();
  std::vector<std::pair<std::int64_t, TileKey>> oldest_first;
  for (auto& [key, tile] : tiles_) {
    settle(tile, now);
    if (now - tile.used_at > kInUse && !tile.building) oldest_first.emplace_back(tile.used_at, key);
  }
  std::sort(oldest_first.begin(), oldest_first.end());
  for (const auto& [used_at, key] : oldest_first) {
    if (bytes_ <= budget_) return;
    const auto found = tiles_.find(key);
    bytes_ -= found->second.counted;
    spare_bytes_ -= found->second.spare;
    tiles_.erase(found);
  }
}

}  // namespace voxatlas
