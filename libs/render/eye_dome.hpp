#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/cell_image.hpp"
#include "render/eye_dome_rows.hpp"

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

/// The same by bands of rows, for whoever goes through the picture anyway.
///
/// Ownership: borrows the image. Threads: light() from any number of threads, a band each.
class EyeDome {
 public:
  EyeDome(const CellImage& image, float roughness);

  static constexpr int kSteps = 2000;  ///< Of light, so that a pixel costs a look.

  /// Rows first .. last - 1, and what they are reckoned from: kept between bands for its memory.
  class Band {
   public:
    std::span<const float> row(int y) const {
      return std::span(light_).subspan(static_cast<std::size_t>(y - first_) * width_, width_);
    }

   private:
    friend EyeDome;
    int first_ = 0;
    std::size_t width_ = 0;
    std::vector<float> inverse_;  // 1 / z, of the rows above and below too; 0 for sky.
    std::vector<float> light_;
  };
  void light(int first, int last, Band& band) const;

 private:
  std::size_t pairs_of(int y, std::span<EyeDomePair> pairs) const;

  const CellImage& image_;
  float roughness_;
  std::array<float, kSteps + 2> by_shade_{};  // One more: a sum of shades is rounded.
};

/// Closes gaps between splats: a pixel that at least six of its eight neighbours stand well before
/// (or that shows sky) takes over the nearest neighbour's cell and depth. Returns how many did.
std::size_t fill_holes(CellImage& image);

}  // namespace voxatlas
