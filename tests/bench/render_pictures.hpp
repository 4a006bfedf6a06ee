#pragma once

#include <filesystem>
#include <vector>

#include "bench/render_splat.hpp"

namespace voxatlas::bench {

/// Writes PNGs into a folder: each view, supersampled; and the first of them with free space, tile
/// boxes, every colouring and depth, holes filled, and by the GL backend; a map of its place.
void write_pictures(const Model& model, const Grid& grid, const std::vector<PlacedTree>& trees,
                    const std::vector<View>& views, const std::filesystem::path& folder);

}  // namespace voxatlas::bench
