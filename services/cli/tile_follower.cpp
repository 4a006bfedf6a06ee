#include "cli/tile_follower.hpp"

#include <algorithm>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kPatience = 2'000'000;
constexpr std::size_t kFetchedAtOnce = 512;
/// Between two rounds of fetching: above depth 7 every change of a tile means fetching it again,
/// and a tile that changes with each scan need not come with each.
constexpr std::int64_t kFetchEvery = 100'000;

/// A store that does not answer now is asked again later.
Status unless_silent(Status done) {
  if (!done && done.error().code == ErrorCode::kUnavailable) return {};
  return done;
}

}  // namespace

TileFollower::TileFollower(ModelClient& client, const TileBox& box, int depth)
    : client_(client),
      box_(box),
      depth_(depth),
      mirror_(box, depth, client.parameters().sensor),
      tallies_(client.parameters().shards) {
  subscriptions_ = {
      client.bus().subscribe<tile_update_t>(
          kTileUpdateChannel, [this](const tile_update_t& update) { on_update(update); }),
      client.bus().subscribe<status_t>(kStatusChannel,
                                       [this](const status_t& status) { on_status(status); })};
}

TileFollower::~TileFollower() {
  for (const auto subscription : subscriptions_) client_.bus().unsubscribe(subscription);
}

void TileFollower::on_update(const tile_update_t& update) {
  const auto key =
      client_.parameters().grid().tile_from_morton(static_cast<std::uint64_t>(update.tile));
  const auto shard = static_cast<std::size_t>(update.shard);
  if (!key || update.version < 1 || shard >= tallies_.size() ||
      shard_of(*key, client_.parameters().shards) != shard) {
    return log_warning("update of tile {:#x}, shard {}, version {}: not of this model",
                       static_cast<std::uint64_t>(update.tile), update.shard, update.version);
  }
  tallies_[shard].on_update(steady_utime());
  const auto version = static_cast<std::uint64_t>(update.version);
  mirror_.on_change(*key, version,
                    update.content == 1 ? std::optional<ByteView>(update.payload) : std::nullopt);
  if (update.content != 2) return;
  auto taken = mirror_.on_tile(*key, version, update.payload);
  if (!taken) log_warning("update of tile {:#x}: {}", key->morton(), taken.error().message);
}

void TileFollower::on_status(const status_t& status) {
  const auto shard = static_cast<std::size_t>(status.index);
  if (status.service != "tilestore" || shard >= tallies_.size()) return;
  const auto published = std::ranges::find(status.counters, "updates_published", &counter_t::name);
  if (published == status.counters.end() || !(published->value >= 0)) return;
  tallies_[shard].on_status(status.instance, static_cast<std::uint64_t>(published->value),
                            steady_utime());
}

Status TileFollower::catch_up() {
  if (auto listed = unless_silent(list_shards()); !listed) return listed;
  if (mirror_.behind() == 0 || steady_utime() < next_fetch_) return {};
  auto fetched = unless_silent(fetch_tiles());
  next_fetch_ = steady_utime() + kFetchEvery;
  return fetched;
}

Status TileFollower::list_shards() {
  const Grid grid = client_.parameters().grid();
  for (std::size_t shard = 0; shard < tallies_.size(); ++shard) {
    if (!tallies_[shard].must_list()) continue;
    ++lists_;
    tallies_[shard].begin_list();
    auto listed = client_.list_shard(static_cast<std::int32_t>(shard), box_, false, kPatience,
                                     [&](const ModelClient::TileRow& row) {
                                       if (const auto key = grid.tile_from_morton(row.key))
                                         mirror_.on_listed(*key, row.version);
                                     });
    tallies_[shard].end_list(listed.has_value());
    if (!listed) return listed;
  }
  return {};
}

Status TileFollower::fetch_tiles() {
  std::vector<std::pair<std::int32_t, std::int64_t>> wanted;
  for (const TileKey key : mirror_.to_fetch(kFetchedAtOnce)) {
    wanted.emplace_back(static_cast<std::int32_t>(shard_of(key, client_.parameters().shards)),
                        static_cast<std::int64_t>(key.morton()));
  }
  return client_.stores().fetch(
      wanted, kPatience,
      [this](StoreClient::FetchedTile tile) {
        const auto key = TileKey::from_morton(static_cast<std::uint64_t>(tile.tile));
        if (!key || tile.version < 1) return;
        auto taken = mirror_.on_tile(*key, static_cast<std::uint64_t>(tile.version), tile.bytes);
        if (!taken) log_warning("tile {:#x}: {}", key->morton(), taken.error().message);
      },
      depth_);
}

std::int64_t TileFollower::next_catch_up() const {
  if (std::ranges::any_of(tallies_, &UpdateTally::must_list)) return 0;
  return mirror_.behind() > 0 ? next_fetch_ : INT64_MAX;
}

bool TileFollower::is_in_step() const {
  return mirror_.behind() == 0 && std::ranges::all_of(tallies_, &UpdateTally::is_complete);
}

std::int64_t TileFollower::last_update() const {
  std::int64_t last = 0;
  for (const auto& tally : tallies_) last = std::max(last, tally.last_update());
  return last;
}

}  // namespace voxatlas
