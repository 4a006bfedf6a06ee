#include "render/tile_asker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kRowBytes = 16;
constexpr std::int64_t kRetryMax = 1'000'000;

bool holds(const TileRange& outer, const TileRange& inner) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
  }
  return true;
}

}  // namespace

Result<std::vector<ListedTile>> listed_tiles(const tiles_reply_t& page, const Grid& grid) {
  if (page.tiles < 0 || page.details != 0 ||
      page.rows.size() != static_cast<std::size_t>(page.tiles) * kRowBytes) {
    return fail(ErrorCode::kCorrupt, fmt::format("a page of {} tiles with details {} in {} bytes",
                                                 page.tiles, page.details, page.rows.size()));
  }
  std::vector<ListedTile> tiles;
  ByteReader rows(page.rows);
  for (std::int32_t i = 0; i < page.tiles; ++i) {
    auto key = grid.tile_from_morton(rows.get<std::uint64_t>());
    if (!key) return pass_on(key);
    tiles.push_back({*key, rows.get<std::uint64_t>()});
  }
  return tiles;
}

bool TileAsker::Retry::due(std::int64_t now) {
  if (now < next) return false;
  next = now + interval;
  interval = std::min(2 * interval, kRetryMax);
  return true;
}

void TileAsker::list(const TileRange& range, std::int64_t now) {
  if (listings_.size() >= kListings) return;
  for (const auto& [number, open] : listings_) {
    if (holds(open.listing.range, range)) return;
  }
  const std::int64_t number = ++last_id_;
  listings_.emplace(number, OpenListing{{range, {}, now}, config_.shards});
  for (std::uint32_t shard = 0; shard < config_.shards; ++shard) {
    Retry retry;
    retry.until = now + kPatience;
    pages_.emplace(++last_id_, ShardPage{number, static_cast<std::int32_t>(shard), 0, retry});
  }
}

void TileAsker::want(std::vector<WantedTile> tiles) {
  wanted_ = std::move(tiles);
  std::reverse(wanted_.begin(), wanted_.end());
}

void TileAsker::on_tiles_reply(const tiles_reply_t& reply, std::int64_t now) {
  const auto page = pages_.find(reply.id);
  if (reply.client != config_.client || page == pages_.end()) return;
  if (reply.shard == page->second.shard) take_page(page, reply, now);
}

void TileAsker::take_page(std::map<std::int64_t, ShardPage>::iterator page,
                          const tiles_reply_t& reply, std::int64_t now) {
  ShardPage asked = page->second;
  auto listed = listed_tiles(reply, grid_);
  const bool forward = reply.next < 0 || reply.next > asked.from;
  if (!listed || !forward) {
    ++refused_;
    log_warning("tilestore {}: {}", asked.shard,
                listed ? fmt::format("a page from {:#x} goes on at {:#x}", asked.from, reply.next)
                       : listed.error().message);
    return give_up(asked.listing);
  }
  pages_.erase(page);
  OpenListing& open = listings_.at(asked.listing);
  auto& tiles = open.listing.tiles;
  tiles.insert(tiles.end(), listed->begin(), listed->end());
  if (reply.next >= 0) {
    asked.from = reply.next;
    asked.retry = Retry();
    asked.retry.until = now + kPatience;
    pages_.emplace(++last_id_, asked);
    return;
  }
  if (--open.shards_left > 0) return;
  listed_.push_back(std::move(open.listing));
  listings_.erase(asked.listing);
}

void TileAsker::give_up(std::int64_t listing) {
  listings_.erase(listing);
  std::erase_if(pages_, [listing](const auto& page) { return page.second.listing == listing; });
}

void TileAsker::on_tile_reply(const tile_reply_t& reply, std::int64_t now) {
  const auto found = fetches_.find(reply.id);
  if (reply.client != config_.client || found == fetches_.end()) return;
  if (reply.tile != static_cast<std::int64_t>(found->second.key.morton()) || reply.version < 0) {
    ++refused_;
    return;
  }
  Fetch fetch = std::move(found->second);
  fetches_.erase(found);
  const auto version = static_cast<std::uint64_t>(reply.version);
  const bool goes_on = fetch.begun && version == fetch.version && reply.total == fetch.total &&
                       static_cast<std::size_t>(reply.offset) == fetch.bytes.size();
  if (!goes_on) fetch.bytes.clear();  // It changed under way: from the beginning.
  fetch.begun = goes_on || reply.offset == 0;
  if (fetch.begun) {
    fetch.version = version;
    fetch.total = reply.total;
    fetch.bytes.insert(fetch.bytes.end(), reply.payload.begin(), reply.payload.end());
  }
  if (fetch.begun && fetch.bytes.size() >= static_cast<std::size_t>(std::max(fetch.total, 0))) {
    under_way_.erase(fetch.key);
    arrived_.push_back({fetch.key, fetch.version, std::move(fetch.bytes), fetch.depth});
    return;
  }
  fetch.retry = Retry();
  fetch.retry.until = now + kPatience;
  fetches_.emplace(++last_id_, std::move(fetch));
}

void TileAsker::begin_fetches(std::int64_t now) {
  while (!wanted_.empty() && fetches_.size() < config_.at_once) {
    const WantedTile wanted = wanted_.back();
    wanted_.pop_back();
    if (!under_way_.insert(wanted.key).second) continue;
    Fetch fetch{wanted.key, wanted.depth, 0, {}, false, 0, {}};
    fetch.retry.until = now + kPatience;
    fetches_.emplace(++last_id_, std::move(fetch));
  }
}

TileAsker::Questions TileAsker::poll(std::int64_t now) {
  Questions questions;
  std::vector<std::int64_t> silent;
  for (auto& [id, page] : pages_) {
    if (now >= page.retry.until) {
      silent.push_back(page.listing);
    } else if (page.retry.due(now)) {
      questions.lists.push_back(question(page, id, now));
    }
  }
  for (const std::int64_t listing : silent) give_up(listing);
  std::erase_if(fetches_, [&](const auto& fetch) {
    const bool over = now >= fetch.second.retry.until;
    if (over) under_way_.erase(fetch.second.key);
    return over;
  });
  begin_fetches(now);
  for (auto& [id, fetch] : fetches_) {
    if (fetch.retry.due(now)) questions.tiles.push_back(question(fetch, id, now));
  }
  return questions;
}

tiles_request_t TileAsker::question(const ShardPage& page, std::int64_t id,
                                    std::int64_t now) const {
  const TileRange& range = listings_.at(page.listing).listing.range;
  tiles_request_t request{};
  request.utime = utime_now();
  request.client = config_.client;
  request.id = id;
  request.deadline = request.utime + page.retry.until - now;
  request.reply_port = config_.reply_port;
  request.shard = page.shard;
  request.from = page.from;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    request.min_index[axis] = static_cast<std::int32_t>(range.min[axis]);
    request.max_index[axis] = static_cast<std::int32_t>(range.max[axis]);
  }
  return request;
}

tile_request_t TileAsker::question(const Fetch& fetch, std::int64_t id, std::int64_t now) const {
  tile_request_t request{};
  request.utime = utime_now();
  request.client = config_.client;
  request.id = id;
  request.deadline = request.utime + fetch.retry.until - now;
  request.reply_port = config_.reply_port;
  request.shard = static_cast<std::int32_t>(shard_of(fetch.key, config_.shards));
  request.tile = static_cast<std::int64_t>(fetch.key.morton());
  request.offset = static_cast<std::int32_t>(fetch.bytes.size());
  request.depth = static_cast<std::int8_t>(fetch.depth);
  return request;
}

std::int64_t TileAsker::next_poll() const {
  std::int64_t next = INT64_MAX;
  if (!wanted_.empty() && fetches_.size() < config_.at_once) next = 0;
  for (const auto& [id, page] : pages_) {
    next = std::min({next, page.retry.next, page.retry.until});
  }
  for (const auto& [id, fetch] : fetches_) {
    next = std::min({next, fetch.retry.next, fetch.retry.until});
  }
  return next;
}

std::vector<Listing> TileAsker::take_listings() { return std::exchange(listed_, {}); }
std::vector<ArrivedTile> TileAsker::take_tiles() { return std::exchange(arrived_, {}); }

}  // namespace voxatlas
