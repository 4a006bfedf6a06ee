#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "grid/tile_key.hpp"

namespace voxatlas {

/// Which compressor has which tile: each tile one, until it is answered. A state machine without a
/// bus.
///
/// Again: a tile whose compressor has not been heard of for kPatience goes to another. One that is
///        merely slow is heard of (a stream's probes are answered between two tiles), and keeps it.
/// Time:  microseconds of one steady clock, given with each call.
/// Threads: one at a time. Memory: kMaxOut keys.
class Handout {
 public:
  static constexpr std::size_t kMaxOut = 64, kMaxOutEach = 16;
  static constexpr std::int64_t kPatience = 10'000'000;
  /// One that was given something and says nothing for so long gets no more.
  static constexpr std::int64_t kQuiet = 2'000'000;

  /// What is seen of a compressor's stream.
  struct Seen {
    bool has_room = true;
    bool holds = false;           ///< Something it has not committed.
    std::int64_t last_heard = 0;  ///< 0: never.
  };

  explicit Handout(std::size_t compressors) : compressors_(compressors) {}

  /// Whom to give a tile: of those who answer and have room, who has least to do; nullopt: nobody.
  /// One that was never heard of is tried with a tile: there may be fewer than there might be.
  std::optional<std::size_t> whom(std::span<const Seen> seen, std::int64_t now) const;
  void given(TileKey tile, std::size_t to, std::int64_t now);
  void answered(TileKey tile);
  /// Forgets what the silent ones have. Returns how many tiles that were.
  std::size_t take_back(std::span<const Seen> seen, std::int64_t now);

  bool has(TileKey tile) const { return out_.contains(tile); }
  bool is_full() const { return out_.size() >= kMaxOut; }
  std::size_t out() const { return out_.size(); }

 private:
  struct Compressor {
    std::size_t out = 0;
    std::int64_t given = 0;  ///< When it was last given a tile.
  };
  bool is_heard(std::size_t i, const Seen& seen, std::int64_t now, std::int64_t within) const;

  std::vector<Compressor> compressors_;
  std::map<TileKey, std::size_t> out_;  ///< Who has it.
};

}  // namespace voxatlas
