#pragma once

#include <cstdint>
#include <vector>

#include "atlas/tile_mirror.hpp"
#include "atlas/update_tally.hpp"
#include "base/result.hpp"
#include "bus/bus.hpp"
#include "cli/model_client.hpp"

namespace voxatlas {

/// A late joiner on the bus: keeps a copy of the tiles in a box, at a depth, in step with the
/// stores. Hears their updates and statuses, lists a shard when it is new or an update was lost,
/// and fetches what is behind.
///
/// Source:  DESIGN section 6, late joiner; lcmtypes/README.md.
/// Threads: one at a time; handlers run inside the client's calls.
class TileFollower {
 public:
  TileFollower(ModelClient& client, const TileBox& box, int depth);
  ~TileFollower();

  /// Lists and fetches what is missing now; blocks while it does, a few seconds at most. Stores
  /// that do not answer are asked again by the next call. Errors: the bus's.
  Status catch_up();
  /// When catch_up() has something to do even if nothing comes in; steady microseconds.
  std::int64_t next_catch_up() const;

  /// Whether the copy is what the stores had when they last told.
  bool is_in_step() const;
  /// When the last update of any shard came; 0: none yet.
  std::int64_t last_update() const;

  const TileMirror& mirror() const { return mirror_; }
  std::uint64_t lists() const { return lists_; }  ///< Times a shard was listed.

 private:
  Status list_shards();
  Status fetch_tiles();
  void on_update(const tile_update_t& update);
  void on_status(const status_t& status);

  ModelClient& client_;
  TileBox box_;
  int depth_;
  TileMirror mirror_;
  std::vector<UpdateTally> tallies_;  ///< By shard.
  std::vector<Bus::Subscription> subscriptions_;
  std::int64_t next_fetch_ = 0;
  std::uint64_t lists_ = 0;
};

}  // namespace voxatlas
