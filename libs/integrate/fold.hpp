#pragma once

#include <vector>

#include "integrate/colour_means.hpp"
#include "integrate/integrator.hpp"
#include "integrate/marks.hpp"

namespace voxatlas {

/// Makes every cell of `depth` (5..7) that has a bit in `bits` full.
void widen(BrickBits& bits, int depth);

/// Drops the misses that equal, contain or lie inside a hit and gathers what is left as deltas.
///
/// Source: DESIGN section 4, rules 3 and 4: whatever the two depths are, and wherever the cells
///         came from, as both sets of marks span all tiles of the scan.
/// Result: ascending by tile, none empty, with the two cell counts. `misses` is used up.
ScanDelta fold(Marks& misses, const Marks& hits, const ColourMeans& colours);

}  // namespace voxatlas
