#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "render/tile_source.hpp"

namespace voxatlas {

/// Which tiles exist in the part of the world that was last looked at, and their newest versions:
/// from one listing, kept current by tile updates.
///
/// An update may be lost, so a listing is believed for kBelieved only.
/// Memory: one range of tiles; a listing of another range replaces it.
/// Threads: one at a time.
class TileDirectory {
 public:
  static constexpr std::int64_t kBelieved = 1'000'000;  ///< Microseconds.

  /// True where the last listing holds the whole range and is young enough.
  bool knows(const TileRange& range, std::int64_t now) const;
  /// Takes a listing. Versions that updates brought meanwhile are kept where they are higher.
  void take(const TileRange& range, const std::vector<ListedTile>& tiles, std::int64_t now);
  /// A tile's new version, if it lies in the range; nothing otherwise.
  void update(TileKey key, std::uint64_t version);

  std::vector<TileKey> keys() const;
  std::uint64_t version(TileKey key) const;  ///< 0 where it is not known to exist.
  std::size_t size() const { return versions_.size(); }

 private:
  TileRange range_{{1, 1, 1}, {0, 0, 0}};  // Nothing.
  std::int64_t listed_at_ = 0;
  std::unordered_map<TileKey, std::uint64_t> versions_;
};

}  // namespace voxatlas
