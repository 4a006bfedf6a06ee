#pragma once

#include <cstdint>

#include "atlas/atlas.hpp"
#include "base/result.hpp"
#include "bus/wire.hpp"
#include "store/tile_store.hpp"

namespace voxatlas {

/// Answers what others ask of a shard. Each answer fits a datagram and asking again is harmless.
///
/// Errors: kOutOfRange for a question that cannot be (a key off the grid, an offset beyond the
/// tile), and
///         the atlas's own. Threads: one at a time.
class TileQueries {
 public:
  TileQueries(Atlas& atlas, TileStore& store);

  Result<model_reply_t> answer(const model_request_t& request);
  Result<tiles_reply_t> answer(const tiles_request_t& request);
  Result<tile_reply_t> answer(const tile_request_t& request);

 private:
  Status add_row(const TileInfo& tile, bool details, Bytes& rows);

  Atlas& atlas_;
  TileStore& store_;
};

}  // namespace voxatlas
