#pragma once

#include <vector>

#include "codec/range_coder.hpp"
#include "octree/log_odds.hpp"

namespace voxatlas {

/// The different log-odds of a tile, rising. Log-odds come from hits and misses: most are another
/// one, or 0, plus one hit or one miss, clamped, and cost a fraction of a bit. FORMAT.md.
void code_palette(RangeEncoder& coder, const std::vector<LogOdds>& palette);

/// False for bits that no encoder wrote. Memory: at most 65 535 values.
bool code_palette(RangeDecoder& coder, std::vector<LogOdds>& palette);

}  // namespace voxatlas
