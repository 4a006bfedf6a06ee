#pragma once

#include <chrono>
#include <cstdint>
#include <list>
#include <unordered_map>
#include <vector>

#include "grid/tile_key.hpp"

namespace voxatlas {

/// Tiles whose stored bytes a compressor could make smaller, in the order they came to rest.
///
/// Memory: at most kLimit tiles; the oldest are forgotten beyond it, and said so by overflowed().
class RestedTiles {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kLimit = 16'384;

  struct Tile {
    TileKey key;
    std::uint64_t version = 0;
    Clock::time_point since;
  };

  /// The tile was written by the fast codec, in this version.
  void add(TileKey key, std::uint64_t version, Clock::time_point since);
  /// The tile changed, or has been compressed.
  void remove(TileKey key);
  /// Up to `limit` that rest since `before` or longer.
  std::vector<Tile> oldest(std::size_t limit, Clock::time_point before) const;

  std::size_t size() const { return tiles_.size(); }
  bool overflowed() const { return overflowed_; }

 private:
  std::list<Tile> tiles_;
  std::unordered_map<TileKey, std::list<Tile>::iterator> by_key_;
  bool overflowed_ = false;
};

}  // namespace voxatlas
