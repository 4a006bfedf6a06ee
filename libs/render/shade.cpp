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

/// A direction, or a place, by pixel of a row: at(x) = first + x * step.
struct AlongRow {
  Eigen::Vector3f first, step;
  Eigen::Vector3f at(int x) const { return first + static_cast<float>(x) * step; }
};

/// How high what a row's pixels show lies above the camera.
struct HeightsAlongRow {
  HeightsAlongRow(const AlongRow& starts, const AlongRow& sights, const Eigen::Vector3f& up)
      : start(starts.first.dot(up)),
        start_step(starts.step.dot(up)),
        sight(sights.first.dot(up)),
        sight_step(sights.step.dot(up)) {}
  float at(int x, float z) const {
    const auto pixels = static_cast<float>(x);
    return start + pixels * start_step + z * (sight + pixels * sight_step);
  }
  float start, start_step, sight, sight_step;
};

/// All that pixels are coloured by; bands of rows by any number of threads.
class TreeShader {
 public:
  TreeShader(const CellImage& cells, const TreeNumbers& numbers, const Camera& camera,
             const Grid& grid, const SceneHeights& heights, Colouring colouring)
      : cells_(cells),
        numbers_(numbers),
        camera_(camera),
        colouring_(colouring),
        ecef_from_camera_(camera.rotation().transpose()),
        dome_(cells, roughness_of(cells, numbers, grid)),
        normals_(CellPaint::normals()),
        sun_(heights.up_ecef),
        up_(heights.up_ecef.cast<float>()),
        east_(east_of(heights.up_ecef).cast<float>()),
        ground_(heights.ground),
        height_(to_geodetic(camera.position()).value().height),
        by_height_(colouring == Colouring::kHeight ? height_colour : neutral_colour, heights.rise) {
  }

  /// What a thread keeps between bands.
  struct Scratch {
    EyeDome::Band light;
    TreeNumbers::Run near;  // Neighbours often show the same tree.
  };

  void band(int first, int last, Scratch& scratch, Image& image) const {
    dome_.light(first, last, scratch.light);
    for (int y = first; y < last; ++y) {
      for (int x = 0; x < cells_.width; x += kRun) run(x, y, scratch, image);
    }
  }

 private:
  static constexpr int kRun = 128;  // Pixels.
  using Run = std::array<const CellPaint*, kRun>;

  /// The paints lie all over memory: they are called for first, and wait for one another least so.
  void look_up(int first, int last, int y, TreeNumbers::Run& near, Run& shown) const {
    const std::uint32_t* cells = cells_.cell.data() + cells_.index(first, y);
    for (int i = 0; i < last - first; ++i) {
      const std::uint32_t number = cells[i];
      if (number == CellImage::kNone) continue;
      if (number - near.first >= near.count) near = numbers_.run_of(number);
      const CellPaint* paint = near.paints + (number - near.first);
      shown[static_cast<std::size_t>(i)] = paint;
      __builtin_prefetch(paint);
    }
  }

  void run(int first, int y, Scratch& scratch, Image& image) const {
    const int last = std::min(cells_.width, first + kRun);
    Run shown{};
    look_up(first, last, y, scratch.near, shown);
    const auto light = scratch.light.row(y);
    const AlongRow sights = along(y, [&](double px, double py) { return camera_.ray(px, py); });
    const HeightsAlongRow heights(
        along(y, [&](double px, double py) { return camera_.point(px, py, 0); }), sights, up_);
    std::uint32_t shaded = CellImage::kNone;
    Rgb colour;
    for (int x = first; x < last; ++x) {
      const std::size_t at = cells_.index(x, y);
      const std::uint32_t number = cells_.cell[at];
      if (number == CellImage::kNone) {
        const Eigen::Vector3f sight = sights.at(x);
        image.at(x, y) = sky_.at(sight.dot(up_) / sight.norm());
        continue;
      }
      if (number != shaded) {
        const Eigen::Vector3f sight = sights.at(x);
        const auto height = [&] { return static_cast<double>(heights.at(x, cells_.z[at])); };
        colour = colour_of(*shown[static_cast<std::size_t>(x - first)], number, sight, height);
      }
      shaded = number;
      image.at(x, y) = lit(colour, light[static_cast<std::size_t>(x)]);
    }
  }

  /// What `of` says of pixels' middles in the camera's frame, along row y in ECEF.
  template <class Of>
  AlongRow along(int y, const Of& of) const {
    const Eigen::Vector3d first = ecef_from_camera_ * of(0.5, y + 0.5);
    const Eigen::Vector3d second = ecef_from_camera_ * of(1.5, y + 0.5);
    return {first.cast<float>(), (second - first).cast<float>()};
  }

  /// `height()`: above the camera, metres; most colours do without.
  template <class Height>
  Rgb colour_of(const CellPaint& paint, std::uint32_t number, const Eigen::Vector3f& sight,
                const Height& height) const {
    const Eigen::Vector3f& normal = normals_[paint.normal_index()];
    if (colouring_ == Colouring::kNormal) return normal_colour(normal, sight);
    return lit(own(paint, number, height), sun_.on(normal, sight));
  }
  /// The side that is seen.
  Rgb normal_colour(Eigen::Vector3f normal, const Eigen::Vector3f& sight) const {
    if (normal.isZero(0)) return {128, 128, 128};
    if (normal.dot(sight) > 0) normal = -normal;
    const auto level = [](float x) {
      return static_cast<std::uint8_t>(std::lround(127.5f + 127.5f * std::clamp(x, -1.0f, 1.0f)));
    };
    return {level(normal.dot(east_)), level(normal.dot(up_.cross(east_))), level(normal.dot(up_))};
  }
  template <class Height>
  Rgb own(const CellPaint& paint, std::uint32_t number, const Height& height) const {
    if (colouring_ == Colouring::kProbability) {
      return ramp_colour(2 * to_probability(paint.log_odds()) - 1);
    }
    if (colouring_ == Colouring::kLeafDepth)
      return depth_colour(numbers_.depth(numbers_.find(number)));
    if (colouring_ == Colouring::kEllipsoid) return ellipsoid_colour(height_ + height());
    if (colouring_ == Colouring::kRgb && paint.coloured()) return paint.rgb();
    return by_height_.at(height() - ground_);
  }

  const CellImage& cells_;
  const TreeNumbers& numbers_;
  const Camera& camera_;
  Colouring colouring_;
  Eigen::Matrix3d ecef_from_camera_;
  EyeDome dome_;
  const std::vector<Eigen::Vector3f>& normals_;
  Sun sun_;
  Eigen::Vector3f up_, east_;
  double ground_;
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

void shade(const CellImage& cells, const TreeNumbers& numbers, const Camera& camera,
           const Grid& grid, const SceneHeights& heights, Colouring colouring, Workers& workers,
           Image& image) {
  const TreeShader shader(cells, numbers, camera, grid, heights, colouring);
  image.width = cells.width;
  image.height = cells.height;
  image.pixels.resize(cells.cell.size());
  std::vector<TreeShader::Scratch> scratch(workers.count());
  constexpr int kRows = 16;
  const auto bands = static_cast<std::size_t>((cells.height + kRows - 1) / kRows);
  workers.run(bands, [&](std::size_t band, std::size_t worker) {
    const int first = static_cast<int>(band) * kRows;
    shader.band(first, std::min(cells.height, first + kRows), scratch[worker], image);
  });
}

}  // namespace voxatlas
