#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "geodesy/ecef.hpp"
#include "render/eye_dome.hpp"
#include "render/light.hpp"
#include "render/ramp.hpp"
#include "render/shade.hpp"
#include "render/splatter.hpp"
#include "scene.hpp"

namespace voxatlas {
namespace {

class ShadedStreet {
 public:
  ShadedStreet() {
    for (const auto& [key, tile] : scene_.tiles()) trees_.emplace_back(tile);
    std::size_t next = 0;
    for (const auto& [key, tile] : scene_.tiles()) placed_.push_back({key, &trees_[next++]});
  }

  Image shaded(Colouring colouring, std::size_t threads) {
    Splatter splatter(threads);
    REQUIRE(splatter.draw(camera_, scene_.grid(), placed_, {}, cells_).has_value());
    Image image;
    shade(cells_, TreeNumbers(placed_), camera_, scene_.grid(), heights(), colouring,
          splatter.workers(), image);
    return image;
  }

  SceneHeights heights() const { return scene_heights(camera_, scene_.grid(), placed_); }
  const CellImage& cells() const { return cells_; }
  const test::Scene& scene() const { return scene_; }
  const Camera& camera() const { return camera_; }
  const CellPaint& paint(std::size_t at) const {
    const TreeNumbers numbers(placed_);
    return numbers.paint(numbers.find(cells_.cell[at]));
  }

 private:
  test::Scene scene_ = test::street_scene();
  Camera camera_ = scene_.camera({-20, 0, 2}, {20, 0, 2.5}, Lens::of_view(60, 213, 120)).value();
  std::vector<RenderTree> trees_;
  std::vector<PlacedTree> placed_;
  CellImage cells_;
};

TEST_CASE("a pixel has its cell's colour, darkened alike in all channels", "[shade][splat]") {
  ShadedStreet street;
  const Image image = street.shaded(Colouring::kRgb, 1);
  std::size_t shown = 0, sky = 0;
  for (std::size_t at = 0; at < image.pixels.size(); ++at) {
    const Rgb pixel = image.pixels[at];
    if (street.cells().cell[at] == CellImage::kNone) {
      ++sky;
      REQUIRE(pixel.b >= pixel.r);
      continue;
    }
    ++shown;
    const Rgb own = street.paint(at).rgb();
    const double light = pixel.r / static_cast<double>(own.r);
    REQUIRE(light <= 1.01);
    REQUIRE(light >= kDarkest * 0.35 - 0.02);
    REQUIRE(std::abs(pixel.g - light * own.g) <= 2);
    REQUIRE(std::abs(pixel.b - light * own.b) <= 2);
  }
  REQUIRE(shown > image.pixels.size() / 2);
  REQUIRE(sky > 500);
}

TEST_CASE("threads do not change how trees are shaded", "[shade][splat]") {
  ShadedStreet street;
  for (const auto colouring : {Colouring::kRgb, Colouring::kHeight, Colouring::kProbability,
                               Colouring::kLeafDepth, Colouring::kEllipsoid, Colouring::kNormal}) {
    REQUIRE(street.shaded(colouring, 1) == street.shaded(colouring, 3));
  }
}

TEST_CASE("coloured by the ellipsoid, a pixel tells its height", "[shade][splat]") {
  ShadedStreet street;
  const Image image = street.shaded(Colouring::kEllipsoid, 1);
  const Eigen::Matrix3d ecef_from_camera = street.camera().rotation().transpose();
  for (int y = 0; y < image.height; y += 3) {
    for (int x = 0; x < image.width; x += 3) {
      const std::size_t at = street.cells().index(x, y);
      if (street.cells().cell[at] == CellImage::kNone) continue;
      const Eigen::Vector3d p_ecef =
          street.camera().position() +
          ecef_from_camera *
              street.camera().point(x + 0.5, y + 0.5, static_cast<double>(street.cells().z[at]));
      const Rgb own = ellipsoid_colour(to_geodetic(p_ecef).value().height);
      const Rgb pixel = image.at(x, y);
      const double light = pixel.g / static_cast<double>(own.g);
      CAPTURE(x, y);
      REQUIRE(light <= 1.02);
      REQUIRE(std::abs(pixel.r - light * own.r) <= 3);
      REQUIRE(std::abs(pixel.b - light * own.b) <= 3);
    }
  }
}

TEST_CASE("a height's colour is its own, and turns every 50 m", "[shade]") {
  REQUIRE(ellipsoid_colour(0) == ramp_colour(0));
  REQUIRE(ellipsoid_colour(25) == ramp_colour(0.5));
  REQUIRE(ellipsoid_colour(50) == ramp_colour(1));
  REQUIRE(ellipsoid_colour(75) == ramp_colour(0.5));
  REQUIRE(ellipsoid_colour(-25) == ramp_colour(0.5));
  REQUIRE(ellipsoid_colour(1000) == ramp_colour(0));
}

TEST_CASE("coloured by normals, the ground is blue and a wall looks towards the eye",
          "[shade][splat]") {
  ShadedStreet street;
  const Image image = street.shaded(Colouring::kNormal, 1);
  std::size_t ground = 0, wall = 0, shown = 0;
  for (std::size_t at = 0; at < image.pixels.size(); ++at) {
    if (street.cells().cell[at] == CellImage::kNone) continue;
    ++shown;
    const Rgb pixel = image.pixels[at];
    ground += pixel.b > 1.5 * pixel.r && pixel.b > 1.5 * pixel.g;      // Up.
    wall += pixel.g > 1.5 * pixel.b || 1.5 * pixel.g < pixel.b * 0.9;  // North or south.
  }
  REQUIRE(ground * 5 > shown);
  REQUIRE(wall * 5 > shown);
}

TEST_CASE("the heights of a scene are those of its cells, of coarse trees too",
          "[shade][splat][oracle]") {
  const ShadedStreet street;
  const auto found = street.heights();
  REQUIRE(found.up_ecef == up_at(street.camera().position()));
  std::vector<double> heights;
  std::vector<RenderTree> coarse;
  std::vector<PlacedTree> placed;
  coarse.reserve(street.scene().tiles().size());
  for (const auto& [key, tile] : street.scene().tiles()) {
    placed.push_back({key, &coarse.emplace_back(tile, 0, 4)});
    tile.for_each_cell(kDepth, [&, at = key](const Leaf& leaf) {
      const Box box = street.scene().grid().box(at, leaf.cell);
      heights.push_back(found.up_ecef.dot((box.min + box.max) / 2 - street.camera().position()));
    });
  }
  std::sort(heights.begin(), heights.end());
  const double ground = heights[heights.size() / 20], top = heights[heights.size() * 99 / 100];
  REQUIRE(std::abs(found.ground - ground) < 0.4);
  REQUIRE(std::abs(found.rise - std::clamp(top - ground, 5.0, 25.0)) < 0.8);
  const auto roughly = scene_heights(street.camera(), street.scene().grid(), placed);
  REQUIRE(std::abs(roughly.ground - ground) < 1);
}

TEST_CASE("the sky is as light by steps as it is by itself", "[shade]") {
  const SkyColours sky;
  for (int i = -1000; i <= 1000; ++i) {
    if (i == -1 || i == 0) continue;  // The horizon itself is an edge.
    const Rgb exact = sky_colour(i / 1000.0), stepped = sky.at(static_cast<float>(i) / 1000);
    REQUIRE(std::abs(exact.r - stepped.r) <= 2);
    REQUIRE(std::abs(exact.g - stepped.g) <= 2);
    REQUIRE(std::abs(exact.b - stepped.b) <= 2);
  }
}

}  // namespace
}  // namespace voxatlas
