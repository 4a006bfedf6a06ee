#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "render/render_tree.hpp"

namespace voxatlas {

/// Tiles that were fetched, encoded as they came, and the render trees made of them.
///
/// Memory:  at most the budget, but for what one picture needs at once: the least recently drawn go
///          first; a tile of the picture being drawn never goes.
/// Threads: one at a time. A tree's address is good until begin_picture(), put() of its tile or
///          trim().
class TreeCache {
 public:
  explicit TreeCache(std::size_t budget_bytes) : budget_(budget_bytes) {}

  /// Tiles asked for from here on belong to this picture.
  void begin_picture() { ++picture_; }

  /// Replaces what was there, unless that is as new.
  void put(TileKey key, std::uint64_t version, Bytes bytes);
  /// 0 where it is not here.
  std::uint64_t version(TileKey key) const;

  /// The tile as it is drawn; made now if it was not. Errors: kNotFound where the tile
  /// is not here, decode_tile's where its bytes are no tile (said again each time).
  Result<const RenderTree*> tree(TileKey key);

  /// Drops tiles until the budget holds or only this picture's are left.
  void trim();

  std::size_t bytes() const { return bytes_; }
  std::size_t budget() const { return budget_; }
  std::size_t tiles() const { return tiles_.size(); }

 private:
  struct Tile {
    std::uint64_t version = 0;
    std::uint64_t picture = 0;  // The last that drew it.
    Bytes encoded;
    std::optional<RenderTree> tree;
    std::size_t bytes() const;
  };

  std::size_t budget_;
  std::size_t bytes_ = 0;
  std::uint64_t picture_ = 0;
  std::unordered_map<TileKey, Tile> tiles_;
};

}  // namespace voxatlas
