#pragma once

#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas {

/// What the leaves know, in their order, for encode_nodes and decode_nodes. Layouts: FORMAT.md.

/// Log-odds come from few hit and miss histories, so few values are common: a palette sorted by
/// how often each occurs, then an index for each leaf, low bytes first.
void write_log_odds(std::span<const Leaf> leaves, ByteWriter& out);
/// Sets the log-odds of every state. Errors: kCorrupt for what write_log_odds does not write.
Status read_log_odds(ByteReader& in, std::span<CellState> states);

/// A flag for each occupied leaf, then counts and means of those that have a colour, a byte plane
/// each.
void write_colours(std::span<const Leaf> leaves, ByteWriter& out);
/// Sets the colours; the log-odds are there. Errors: kCorrupt likewise.
Status read_colours(ByteReader& in, std::span<CellState> states);

}  // namespace voxatlas
