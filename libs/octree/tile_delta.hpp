#pragma once

#include <cstdint>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/cell_set.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

/// What one scan changed in one tile: every cell at most once, as a miss or as a hit.
///
/// Source: the paper's Algorithm 1 (cells_free, cells_occ of one tile); DESIGN section 4.
/// No cell of `misses` equals, contains or lies inside a cell of `hits`: the integrator has applied
/// that rule, and so the order of the two does not matter.
struct TileDelta {
  CellSet misses;
  CellSet hits;
  CellSet coloured;          ///< Those hits that have a colour: same depth, a subset of `hits`.
  std::vector<Rgb> colours;  ///< One for each cell of `coloured`, in CellSet::for_each order.

  bool empty() const { return misses.empty() && hits.empty(); }
  /// True when all of the above holds, of the sets as well; what a decoder checks.
  bool valid() const;

  friend bool operator==(const TileDelta&, const TileDelta&) = default;
};

/// The delta's bytes on the wire and in the journal; layout in FORMAT.md beside this file.
void encode_delta(const TileDelta& delta, Bytes& out);

/// Errors: kCorrupt for anything encode_delta does not write. Memory: bounded by one tile.
Result<TileDelta> decode_delta(ByteView bytes);

}  // namespace voxatlas
