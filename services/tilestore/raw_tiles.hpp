#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "atlas/atlas.hpp"
#include "base/result.hpp"
#include "bus/stream_link.hpp"

namespace voxatlas {

/// Hands tiles that have rested to the compressors, each tile to one of them, a few at a time.
///
/// Nothing waits for an answer: a tile whose compressor died is handed out again after kPatience.
/// Threads: one at a time. Memory: kMaxOut tiles.
class RawTiles {
 public:
  static constexpr std::size_t kMaxOut = 64;
  static constexpr std::int64_t kPatience = 10'000'000;  ///< Microseconds.

  static Result<std::unique_ptr<RawTiles>> create(Bus& bus, std::int32_t compressors);

  /// Offers what has rested and sends what can be sent.
  Status pump(Atlas& atlas, std::int64_t now);
  /// A compressor's answer for this tile has come, whatever the store thought of it.
  void answered(TileKey tile) { out_.erase(tile); }
  std::int64_t next_poll(std::int64_t now);

  std::uint64_t handed_out() const { return handed_out_; }

 private:
  Status hand_out(Atlas& atlas, std::int64_t now);

  std::vector<std::unique_ptr<OutLink>> links_;
  std::size_t turn_ = 0;
  std::map<TileKey, std::int64_t> out_;  ///< Since when.
  std::int64_t next_look_ = 0;
  std::uint64_t handed_out_ = 0;
};

}  // namespace voxatlas
