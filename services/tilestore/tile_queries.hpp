#pragma once

#include <cstdint>

#include "atlas/atlas.hpp"
#include "base/result.hpp"
#include "bus/wire.hpp"
#include "store/tile_store.hpp"
#include "tilestore/source_claims.hpp"
#include "tilestore/tile_contents.hpp"
#include "tilestore/tile_encodings.hpp"

namespace voxatlas {

/// Answers what others ask of a shard. Each answer fits a datagram and asking again is harmless.
///
/// Errors: kOutOfRange for a question that cannot be (a key off the grid, an offset beyond the
/// tile), and
///         the atlas's own. Threads: one at a time.
class TileQueries {
 public:
  TileQueries(Atlas& atlas, TileStore& store);

  /// Takes a claim on the source, too, if the request makes one. Where its holder knows of
  /// acknowledged scans that this shard has not: an alarm, logged and counted.
  Result<model_reply_t> answer(const model_request_t& request);
  Result<tiles_reply_t> answer(const tiles_request_t& request);
  Result<tile_reply_t> answer(const tile_request_t& request);

  std::uint64_t marks_regressed() const { return marks_regressed_; }  ///< Alarms.

 private:
  void check_mark(const model_request_t& request, std::int64_t mark);
  Status add_row(const TileInfo& tile, bool details, Bytes& rows);

  Atlas& atlas_;
  TileStore& store_;
  TileContents contents_;
  TileEncodings encodings_;
  SourceClaims claims_;
  std::uint64_t marks_regressed_ = 0;
};

}  // namespace voxatlas
