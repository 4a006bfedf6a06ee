#pragma once

#include <filesystem>
#include <vector>

#include "bench/render_splat.hpp"

namespace voxatlas::bench {

struct PictureFiles {
  std::filesystem::path folder;
  int jpeg_quality = 0;  ///< 0: PNG.
};

/// Writes pictures into a folder: each view, supersampled; and the first of them with free space,
/// tile boxes, every colouring and depth, holes filled, and by the GL backend; a map of its place.
void write_pictures(const Model& model, const Grid& grid, const std::vector<PlacedTree>& trees,
                    const std::vector<View>& views, const PictureFiles& files);

}  // namespace voxatlas::bench
