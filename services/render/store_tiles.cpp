#include "render/store_tiles.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "grid/region_key.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kRowBytes = 16;

Status list_shard(StoreClient& client, const Grid& grid, std::int32_t shard, const TileRange& range,
                  std::int64_t until, std::vector<ListedTile>& tiles) {
  tiles_request_t request{};
  request.shard = shard;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    request.min_index[axis] = static_cast<std::int32_t>(range.min[axis]);
    request.max_index[axis] = static_cast<std::int32_t>(range.max[axis]);
  }
  while (request.from >= 0) {
    auto page = client.tiles(request, until - steady_utime());
    if (!page) return pass_on(page);
    auto listed = listed_tiles(*page, grid);
    if (!listed) return pass_on(listed, fmt::format("tilestore {}", shard));
    tiles.insert(tiles.end(), listed->begin(), listed->end());
    if (page->next >= 0 && page->next <= request.from) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("tilestore {} goes on from key {:#x} at {:#x}: no way forward", shard,
                              request.from, page->next));
    }
    request.from = page->next;
  }
  return {};
}

Status fetch_tiles(StoreClient& client, const Grid& grid, std::uint32_t shards,
                   const std::vector<TileKey>& keys, std::int64_t timeout_us,
                   const std::function<void(ArrivedTile)>& arrived) {
  std::vector<std::pair<std::int32_t, std::int64_t>> wanted;
  for (const TileKey key : keys) {
    wanted.emplace_back(static_cast<std::int32_t>(shard_of(key, shards)),
                        static_cast<std::int64_t>(key.morton()));
  }
  return client.fetch(wanted, timeout_us, [&](StoreClient::FetchedTile tile) {
    const auto key = grid.tile_from_morton(static_cast<std::uint64_t>(tile.tile));
    if (!key || tile.version < 0) {
      return log_warning("tile {:#x} version {}: refused", tile.tile, tile.version);
    }
    arrived({*key, static_cast<std::uint64_t>(tile.version), std::move(tile.bytes)});
  });
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

TileSource store_tiles(StoreClient& client, const Grid& grid, std::int32_t shards) {
  TileSource source;
  source.list = [&client, grid, shards](
                    const TileRange& range,
                    std::int64_t timeout_us) -> Result<std::vector<ListedTile>> {
    const std::int64_t until = steady_utime() + timeout_us;
    std::vector<ListedTile> tiles;
    for (std::int32_t shard = 0; shard < shards; ++shard) {
      if (auto listed = list_shard(client, grid, shard, range, until, tiles); !listed) {
        return pass_on(listed);
      }
    }
    return tiles;
  };
  source.fetch = [&client, grid, shards](const std::vector<TileKey>& keys, std::int64_t timeout_us,
                                         const std::function<void(ArrivedTile)>& arrived) {
    return fetch_tiles(client, grid, static_cast<std::uint32_t>(shards), keys, timeout_us, arrived);
  };
  return source;
}

}  // namespace voxatlas
