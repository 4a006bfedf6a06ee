#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "render/cell_image.hpp"

namespace voxatlas {

/// A depth image for the wire: little endian, row by row from the upper left; metres along the
/// camera's axis to where the pixel's ray enters the cell that it shows.

/// A float a pixel; infinity where there is nothing.
Bytes depth_metres(const CellImage& cells);

/// Two bytes a pixel that count steps of `metres_a_step`, rounded to nearest; 0 where there is
/// nothing, 1 for what is nearer than that, 65535 for all that is as far or farther.
/// Errors: kOutOfRange for a step that is not positive and finite.
Result<Bytes> depth_steps(const CellImage& cells, double metres_a_step);

}  // namespace voxatlas
