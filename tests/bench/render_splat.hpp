#pragma once

#include <string>

#include "bench/render_model.hpp"
#include "render/camera.hpp"

namespace voxatlas::bench {

/// Prints how long the Splatter takes, beside the GL backend in the same run: the median of
/// `repeat` pictures a line. With `out`, a folder, also PNGs of the three views.
void measure_splatter(const Model& model, const Grid& grid, const Camera& street, int repeat,
                      const std::string& out);

}  // namespace voxatlas::bench
