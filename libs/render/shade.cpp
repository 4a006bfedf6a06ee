#include "render/shade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "geodesy/ecef.hpp"
#include "render/eye_dome.hpp"
#include "render/light.hpp"
#include "render/ramp.hpp"
#include "render/scene_heights.hpp"

namespace voxatlas {
namespace {

constexpr std::array kNames = {"rgb", "height", "probability", "depth"};

/// Of all cells' heights; every so many are enough.
constexpr std::uint64_t kHeightSamples = 100'000;

/// The height of a cloud's cells is affine in their place: base + centre * slope.
struct HeightPlane {
  double base;
  Eigen::Vector3d slope;

  HeightPlane(const PlacedCloud& placed, const Camera& camera, const Grid& grid,
              const Eigen::Vector3d& up)
      : base(up.dot(grid.min_corner(placed.key) - camera.position())),
        slope(up * (0.5 / grid.cells_per_metre())) {}

  double of(const DrawnCell& cell) const {
    return base + slope.x() * cell.centre[0] + slope.y() * cell.centre[1] +
           slope.z() * cell.centre[2];
  }
};

/// Looks a cell's colour up by its number.
class CellColours {
 public:
  CellColours(const CellNumbers& numbers, const Camera& camera, const Grid& grid,
              const SceneHeights& heights, Colouring colouring)
      : numbers_(numbers),
        camera_(camera),
        grid_(grid),
        heights_(heights),
        colouring_(colouring),
        sun_(heights.up_ecef),
        by_height_(colouring == Colouring::kHeight ? height_colour : neutral_colour, heights.rise) {
  }

  Rgb of(std::uint32_t number) const {
    const auto found = numbers_.find(number);
    const DrawnCell& cell = numbers_.cell(found);
    const Eigen::Vector3d normal(cell.normal[0], cell.normal[1], cell.normal[2]);
    const Eigen::Vector3d sight = grid_.min_corner(numbers_.cloud(found).key) - camera_.position() +
                                  cell.centre_voxels().cast<double>() / grid_.cells_per_metre();
    return lit(own(found, cell), sun_.on(normal, sight));
  }

 private:
  Rgb own(const CellNumbers::Found& found, const DrawnCell& cell) const {
    if (colouring_ == Colouring::kProbability) {
      return ramp_colour(2 * to_probability(cell.log_odds) - 1);
    }
    if (colouring_ == Colouring::kLeafDepth) return depth_colour(cell.depth);
    if (colouring_ == Colouring::kRgb && cell.coloured != 0) return cell.rgb;
    const HeightPlane plane(numbers_.cloud(found), camera_, grid_, heights_.up_ecef);
    return by_height_.at(plane.of(cell) - heights_.ground);
  }

  const CellNumbers& numbers_;
  const Camera& camera_;
  const Grid& grid_;
  const SceneHeights& heights_;
  Colouring colouring_;
  Sun sun_;
  HeightColours by_height_;
};

/// The edge of the cells that most pixels show: what a surface of cells is rough by.
float roughness_of(const CellImage& cells, const CellNumbers& numbers, const Grid& grid) {
  std::array<std::size_t, kDepth + 1> count{};
  constexpr std::size_t kEvery = 97;
  for (std::size_t i = 0; i < cells.cell.size(); i += kEvery) {
    if (cells.cell[i] == CellImage::kNone) continue;
    ++count[numbers.cell(numbers.find(cells.cell[i])).depth];
  }
  const auto depth = std::max_element(count.begin(), count.end()) - count.begin();
  return static_cast<float>(grid.cell_length(static_cast<int>(depth)));
}

}  // namespace

const char* name_of(Colouring colouring) { return kNames[static_cast<std::size_t>(colouring)]; }

Result<Colouring> colouring_of(const std::string& name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i]) return static_cast<Colouring>(i);
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("colouring \"{}\" is not one of {}", name, fmt::join(kNames, ", ")));
}

SceneHeights scene_heights(const Camera& camera, const Grid& grid,
                           std::span<const PlacedCloud> clouds) {
  const Eigen::Vector3d up = up_at(camera.position());
  const std::uint64_t every = CellNumbers(clouds).count() / kHeightSamples + 1;
  std::vector<double> samples;
  std::uint64_t skip = 0;
  for (const auto& placed : clouds) {
    const HeightPlane plane(placed, camera, grid, up);
    const auto cells = placed.cloud->cells();
    for (; skip < cells.size(); skip += every) samples.push_back(plane.of(cells[skip]));
    skip -= cells.size();
  }
  return heights_of(up, std::move(samples));
}

Image shade(const CellImage& cells, const CellNumbers& numbers, const Camera& camera,
            const Grid& grid, const SceneHeights& heights, Colouring colouring) {
  const auto light = eye_dome_light(cells, roughness_of(cells, numbers, grid));
  const CellColours colours(numbers, camera, grid, heights, colouring);
  const Eigen::Vector3d up_camera = camera.rotation() * heights.up_ecef;
  Image image(cells.width, cells.height);
  std::uint32_t last = CellImage::kNone;  // Neighbours often show the same cell.
  Rgb colour;
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t at = cells.index(x, y);
      const std::uint32_t number = cells.cell[at];
      if (number == CellImage::kNone) {
        image.at(x, y) = sky_colour(camera.ray(x + 0.5, y + 0.5).normalized().dot(up_camera));
        continue;
      }
      if (number != last) colour = colours.of(number);
      last = number;
      image.at(x, y) = lit(colour, light[at]);
    }
  }
  return image;
}

}  // namespace voxatlas
