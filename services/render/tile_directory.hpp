#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "grid/grid.hpp"
#include "render/frustum.hpp"

namespace voxatlas {

/// A tile that exists, and its newest version.
struct ListedTile {
  TileKey key;
  std::uint64_t version = 0;
};

/// Which tiles exist in the parts of the world that were looked at, and their newest versions: from
/// listings, kept current by tile updates.
///
/// By blocks of 16 x 16 x 16 tiles (205 m), so that a camera that moves asks for little that is
/// new. An update may be lost: a listing is fresh for kFresh only, and is then asked for again.
/// Memory: kMaxBlocks blocks and the tiles in them; those longest not looked at go first.
/// Threads: one at a time.
class TileDirectory {
 public:
  static constexpr std::int64_t kFresh = 1'000'000;  ///< Microseconds.
  static constexpr std::int64_t kBelieved = 2'000'000;
  static constexpr std::size_t kMaxBlocks = 60'000;
  static constexpr std::size_t kMaxView = 40'000;  ///< Blocks in the box around a view.

  explicit TileDirectory(const Grid& grid) : grid_(grid) {}

  /// What is known of what a camera sees.
  struct View {
    std::vector<TileKey> tiles;        ///< In view, nearest first.
    std::int64_t listed_at = 0;        ///< The oldest of its listings; 0: some part has none.
    std::optional<TileRange> to_list;  ///< Blocks that have none, else those not fresh.
  };
  /// Errors: kOutOfRange for a view of more than kMaxView blocks.
  Result<View> look(const Camera& camera, std::int64_t now);

  /// Takes the listing of a range made of whole blocks, asked for at `asked`. Higher versions that
  /// updates told of are kept, unless that was kBelieved before: then they were not true.
  void take(const TileRange& range, const std::vector<ListedTile>& tiles, std::int64_t asked);
  /// A tile's new version, if its block was listed; nothing otherwise. Returns whether somebody has
  /// looked at that block less than kBelieved ago.
  bool update(TileKey key, std::uint64_t version, std::int64_t now);

  std::uint64_t version(TileKey key) const;  ///< 0 where it is not known to exist.
  std::size_t blocks() const { return blocks_.size(); }

 private:
  struct Known {
    std::uint64_t version = 0;
    std::int64_t told_at = 0;
  };
  struct Block {
    std::int64_t listed_at = 0;
    std::int64_t used_at = 0;
    std::unordered_map<TileKey, Known> tiles;
  };
  using BlockCode = std::uint64_t;  // Its index's Morton code.

  void forget_some();

  Grid grid_;
  std::unordered_map<BlockCode, Block> blocks_;
};

}  // namespace voxatlas
