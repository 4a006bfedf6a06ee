#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "atlas/atlas.hpp"
#include "base/result.hpp"
#include "bus/status_counters.hpp"
#include "bus/stream_link.hpp"
#include "tilestore/handout.hpp"

namespace voxatlas {

/// Hands tiles that have rested to the compressors, each tile to one of them, a few at a time.
///
/// Again: a compressor commits a tile when its result has been committed here, so one that is
/// killed
///        gets the tile again when it comes back; if it does not, another one does (Handout).
/// Load:  nothing is handed out while the shard has deltas to apply.
/// Threads: one at a time. Memory: Handout::kMaxOut tiles.
class RawTiles {
 public:
  static Result<std::unique_ptr<RawTiles>> create(Bus& bus, std::int32_t compressors);

  /// Offers what has rested, where the shard is `idle`, and sends what can be sent.
  Status pump(Atlas& atlas, std::int64_t now, bool idle);
  /// A compressor's answer for this tile has come, whatever the store thought of it.
  void answered(TileKey tile) { handout_.answered(tile); }
  std::int64_t next_poll(std::int64_t now);

  void add_to(StatusCounters& counters) const;

 private:
  explicit RawTiles(std::vector<std::unique_ptr<OutLink>> links)
      : links_(std::move(links)), handout_(links_.size()) {}
  std::vector<Handout::Seen> look();
  Status hand_out(Atlas& atlas, std::int64_t now);
  Status give(Atlas& atlas, TileKey tile, std::size_t to, std::int64_t now);

  std::vector<std::unique_ptr<OutLink>> links_;
  Handout handout_;
  std::int64_t next_look_ = 0;
  std::uint64_t handed_out_ = 0, handed_again_ = 0;
};

}  // namespace voxatlas
