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

namespace voxatlas {
namespace {

constexpr std::array kNames = {"rgb", "height", "probability", "depth", "ellipsoid", "normal"};

/// The edge of the cells that most pixels show: what a surface of cells is rough by.
float roughness_of(const CellImage& cells, const TreeNumbers& numbers, const Grid& grid) {
  std::array<std::size_t, kDepth + 1> count{};
  constexpr std::size_t kEvery = 997;
  for (std::size_t i = 0; i < cells.cell.size(); i += kEvery) {
    if (cells.cell[i] == CellImage::kNone) continue;
    ++count[static_cast<std::size_t>(numbers.depth(numbers.find(cells.cell[i])))];
  }
  const auto depth = std::max_element(count.begin(), count.end()) - count.begin();
  return static_cast<float>(grid.cell_length(static_cast<int>(depth)));
}

/// All that pixels are coloured by; rows of them by any number of threads.
class TreeShader {
 public:
  TreeShader(const CellImage& cells, const TreeNumbers& numbers, const Camera& camera,
             const Grid& grid, const SceneHeights& heights, Colouring colouring)
      : cells_(cells),
        numbers_(numbers),
        camera_(camera),
        heights_(heights),
        colouring_(colouring),
        ecef_from_camera_(camera.rotation().transpose()),
        up_camera_(camera.rotation() * heights.up_ecef),
        dome_(cells, roughness_of(cells, numbers, grid)),
        sun_(heights.up_ecef),
        east_(east_of(heights.up_ecef)),
        height_(to_geodetic(camera.position()).value().height),
        by_height_(colouring == Colouring::kHeight ? height_colour : neutral_colour, heights.rise) {
  }

  void row(int y, std::vector<float>& light, Image& image) const {
    light.resize(static_cast<std::size_t>(cells_.width));
    dome_.row(y, light);
    std::uint32_t last = CellImage::kNone;  // Neighbours often show the same cell.
    TreeNumbers::Found found{};
    Rgb colour;
    for (int x = 0; x < cells_.width; ++x) {
      const std::size_t at = cells_.index(x, y);
      const std::uint32_t number = cells_.cell[at];
      const Eigen::Vector3d ray = camera_.ray(x + 0.5, y + 0.5);
      if (number == CellImage::kNone) {
        image.at(x, y) = sky_.at(ray.dot(up_camera_) / ray.norm());
        continue;
      }
      if (number != last) {
        if (!numbers_.holds(found, number)) found = numbers_.find(number);
        found.node = number - numbers_.first_of(found.tree);
        const double z = static_cast<double>(cells_.z[at]);
        colour = colour_of(found, ray, camera_.point(x + 0.5, y + 0.5, z).dot(up_camera_));
      }
      last = number;
      image.at(x, y) = lit(colour, light[static_cast<std::size_t>(x)]);
    }
  }

 private:
  Rgb colour_of(const TreeNumbers::Found& found, const Eigen::Vector3d& ray, double height) const {
    const CellPaint& paint = numbers_.paint(found);
    const Eigen::Vector3d normal = paint.normal().cast<double>();
    const Eigen::Vector3d sight = ecef_from_camera_ * ray;
    if (colouring_ == Colouring::kNormal) return normal_colour(normal, sight);
    return lit(own(found, paint, height), sun_.on(normal, sight));
  }
  /// The side that is seen.
  Rgb normal_colour(Eigen::Vector3d normal, const Eigen::Vector3d& sight) const {
    if (normal.isZero()) return {128, 128, 128};
    if (normal.dot(sight) > 0) normal = -normal;
    const auto level = [](double x) {
      return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(x, -1.0, 1.0)));
    };
    const Eigen::Vector3d& up = heights_.up_ecef;
    return {level(normal.dot(east_)), level(normal.dot(up.cross(east_))), level(normal.dot(up))};
  }
  /// `height`: above the camera, metres.
  Rgb own(const TreeNumbers::Found& found, const CellPaint& paint, double height) const {
    if (colouring_ == Colouring::kProbability) {
      return ramp_colour(2 * to_probability(paint.log_odds()) - 1);
    }
    if (colouring_ == Colouring::kLeafDepth) return depth_colour(numbers_.depth(found));
    if (colouring_ == Colouring::kEllipsoid) return ellipsoid_colour(height_ + height);
    if (colouring_ == Colouring::kRgb && paint.coloured()) return paint.rgb();
    return by_height_.at(height - heights_.ground);
  }

  const CellImage& cells_;
  const TreeNumbers& numbers_;
  const Camera& camera_;
  const SceneHeights& heights_;
  Colouring colouring_;
  Eigen::Matrix3d ecef_from_camera_;
  Eigen::Vector3d up_camera_;
  EyeDome dome_;
  Sun sun_;
  Eigen::Vector3d east_;
  double height_;  // The camera's above the ellipsoid.
  HeightColours by_height_;
  SkyColours sky_;
};

}  // namespace

const char* name_of(Colouring colouring) { return kNames[static_cast<std::size_t>(colouring)]; }

Result<Colouring> colouring_of(const std::string& name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i]) return static_cast<Colouring>(i);
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("colouring \"{}\" is not one of {}", name, fmt::join(kNames, ", ")));
}

Image shade(const CellImage& cells, const TreeNumbers& numbers, const Camera& camera,
            const Grid& grid, const SceneHeights& heights, Colouring colouring, Workers& workers) {
  const TreeShader shader(cells, numbers, camera, grid, heights, colouring);
  Image image(cells.width, cells.height);
  std::vector<std::vector<float>> light(workers.count());
  constexpr int kRows = 16;
  const auto bands = static_cast<std::size_t>((cells.height + kRows - 1) / kRows);
  workers.run(bands, [&](std::size_t band, std::size_t worker) {
    const int first = static_cast<int>(band) * kRows;
    for (int y = first; y < std::min(cells.height, first + kRows); ++y) {
      shader.row(y, light[worker], image);
    }
  });
  return image;
}

}  // namespace voxatlas
