#pragma once

#include <span>
#include <vector>

#include "render/cell_image.hpp"

namespace voxatlas {

/// Light for each pixel, 1 bright .. kDarkest: what lies behind its neighbours gets less, so that
/// edges and hollows show without any normals.
///
/// Source: eye-dome lighting (Boucheny 2009), but on 1/z, which is linear across the picture on any
///         plane: a plane, however tilted, keeps its full light, and the ground does not darken
///         towards the horizon. Each pixel is compared with the mean of opposite neighbours, at
///         two distances.
/// `roughness`: metres that neighbours may differ without meaning: about a cell's edge.
inline constexpr float kDarkest = 0.25f;
std::vector<float> eye_dome_light(const CellImage& image, float roughness);

/// The same row by row, for whoever goes through the picture anyway.
///
/// Ownership: borrows the image. Threads: row() from any number of threads.
class EyeDome {
 public:
  EyeDome(const CellImage& image, float roughness);
  /// Writes the light of row y; `light` has the picture's width.
  void row(int y, std::span<float> light) const;

 private:
  struct Step {
    int dx, dy;
  };
  void add_pair(int y, Step step, std::span<float> shade) const;

  const CellImage& image_;
  float roughness_;
  std::vector<float> inverse_;  // 1 / z; 0 for sky.
};

/// Closes gaps between splats: a pixel that at least six of its eight neighbours stand well before
/// (or that shows sky) takes over the nearest neighbour's cell and depth. Returns how many did.
std::size_t fill_holes(CellImage& image);

}  // namespace voxatlas
