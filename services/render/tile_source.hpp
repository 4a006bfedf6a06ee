#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "render/frustum.hpp"

namespace voxatlas {

/// A tile that exists, and its newest version.
struct ListedTile {
  TileKey key;
  std::uint64_t version = 0;
};

/// A tile as it came: encode_tile's bytes; version 0 and no bytes: never written.
struct ArrivedTile {
  TileKey key;
  std::uint64_t version = 0;
  Bytes bytes;
};

/// Where a renderer gets tiles from: the tile stores, or in tests a map.
struct TileSource {
  /// Every tile of a range. Errors: kUnavailable where it did not come in time.
  std::function<Result<std::vector<ListedTile>>(const TileRange&, std::int64_t timeout_us)> list;
  /// Hands over each tile as it arrives. Errors: kUnavailable if some did not come in time.
  std::function<Status(const std::vector<TileKey>&, std::int64_t timeout_us,
                       const std::function<void(ArrivedTile)>&)>
      fetch;
};

}  // namespace voxatlas
