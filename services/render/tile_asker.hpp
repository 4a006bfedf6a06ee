#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <unordered_set>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "bus/wire.hpp"
#include "grid/grid.hpp"
#include "render/frustum.hpp"
#include "render/tile_directory.hpp"

namespace voxatlas {

/// A tile as it came: encode_tile's bytes; version 0 and no bytes: never written.
struct ArrivedTile {
  TileKey key;
  std::uint64_t version = 0;
  Bytes bytes;
  int depth = kDepth;  ///< That was asked for: a coarse tile has the cells of this depth alone.
};

/// A tile that is wanted, and how much of it.
struct WantedTile {
  TileKey key;
  int depth = kDepth;
};

/// Every tile of a range, and when that was asked for.
struct Listing {
  TileRange range;
  std::vector<ListedTile> tiles;
  std::int64_t asked = 0;
};

/// The rows of one page. Errors: kCorrupt where rows and size contradict; kOutOfRange for a key
/// that the grid has not.
Result<std::vector<ListedTile>> listed_tiles(const tiles_reply_t& page, const Grid& grid);

struct AskerConfig {
  std::uint32_t shards = 1;
  std::int64_t client = 0;
  std::int32_t reply_port = 0;
  std::size_t at_once = 3;  ///< Tiles under way: what the receive buffer takes.
};

/// Asks the tile stores what exists and for tiles, and never waits: questions out, answers in.
///
/// Retry:   a question goes out again after 100 ms, doubling to 1 s; what has not come after
///          kPatience is given up, and may be asked for again.
/// Time:    is told, never read.
/// Memory:  kListings listings and `at_once` tiles under way.
/// Threads: one at a time.
class TileAsker {
 public:
  static constexpr std::int64_t kPatience = 3'000'000;  ///< Microseconds.
  static constexpr std::size_t kListings = 4;

  TileAsker(const Grid& grid, const AskerConfig& config) : grid_(grid), config_(config) {}

  /// Asks for a listing; nothing where one under way holds it, or kListings are.
  void list(const TileRange& range, std::int64_t now);
  /// The tiles wanted now, the most wanted first; those under way go on.
  void want(std::vector<WantedTile> tiles);

  void on_tiles_reply(const tiles_reply_t& reply, std::int64_t now);
  void on_tile_reply(const tile_reply_t& reply, std::int64_t now);

  struct Questions {
    std::vector<tiles_request_t> lists;
    std::vector<tile_request_t> tiles;
  };
  Questions poll(std::int64_t now);
  std::int64_t next_poll() const;  ///< INT64_MAX: nothing is under way.

  std::vector<Listing> take_listings();
  std::vector<ArrivedTile> take_tiles();

  bool asking_for(TileKey key) const { return under_way_.contains(key); }
  std::size_t refused() const { return refused_; }  ///< Answers that contradict themselves.

 private:
  /// When a question goes out, when again, and when no more.
  struct Retry {
    std::int64_t next = 0;
    std::int64_t interval = 100'000;
    std::int64_t until = 0;
    bool due(std::int64_t now);
  };
  struct ShardPage {
    std::int64_t listing = 0;
    std::int32_t shard = 0;
    std::int64_t from = 0;
    Retry retry;
  };
  struct OpenListing {
    Listing listing;
    std::uint32_t shards_left = 0;
  };
  struct Fetch {
    TileKey key;
    int depth = kDepth;
    std::uint64_t version = 0;
    Bytes bytes;
    bool begun = false;
    std::int32_t total = 0;
    Retry retry;
  };

  tiles_request_t question(const ShardPage& page, std::int64_t id, std::int64_t now) const;
  tile_request_t question(const Fetch& fetch, std::int64_t id, std::int64_t now) const;
  void begin_fetches(std::int64_t now);
  void take_page(std::map<std::int64_t, ShardPage>::iterator page, const tiles_reply_t& reply,
                 std::int64_t now);
  void give_up(std::int64_t listing);

  Grid grid_;
  AskerConfig config_;
  std::int64_t last_id_ = 0;
  std::map<std::int64_t, OpenListing> listings_;  // By a number of their own;
  std::map<std::int64_t, ShardPage> pages_;       // by question.
  std::map<std::int64_t, Fetch> fetches_;
  std::unordered_set<TileKey> under_way_;
  std::vector<WantedTile> wanted_;  // The most wanted last.
  std::vector<Listing> listed_;
  std::vector<ArrivedTile> arrived_;
  std::size_t refused_ = 0;
};

}  // namespace voxatlas
