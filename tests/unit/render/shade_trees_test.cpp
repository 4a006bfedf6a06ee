#include <catch2/catch.hpp>
#include <cmath>

#include "render/eye_dome.hpp"
#include "render/light.hpp"
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
    return shade(cells_, TreeNumbers(placed_), camera_, scene_.grid(), heights(), colouring,
                 splatter.workers());
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
  for (const auto colouring :
       {Colouring::kRgb, Colouring::kHeight, Colouring::kProbability, Colouring::kLeafDepth}) {
    REQUIRE(street.shaded(colouring, 1) == street.shaded(colouring, 3));
  }
}

TEST_CASE("the heights of trees are those of their cells", "[shade][splat]") {
  const ShadedStreet street;
  const test::Clouds clouds(street.scene(), kDepth);
  const auto by_trees = street.heights();
  const auto by_cells = scene_heights(street.camera(), street.scene().grid(), clouds.placed());
  REQUIRE(by_trees.up_ecef == by_cells.up_ecef);
  REQUIRE(std::abs(by_trees.ground - by_cells.ground) < 0.4);
  REQUIRE(std::abs(by_trees.rise - by_cells.rise) < 0.8);
}

TEST_CASE("the sky is as light by steps as it is by itself", "[shade]") {
  const SkyColours sky;
  for (int i = -1000; i <= 1000; ++i) {
    if (i == -1 || i == 0) continue;  // The horizon itself is an edge.
    const Rgb exact = sky_colour(i / 1000.0), stepped = sky.at(i / 1000.0);
    REQUIRE(std::abs(exact.r - stepped.r) <= 2);
    REQUIRE(std::abs(exact.g - stepped.g) <= 2);
    REQUIRE(std::abs(exact.b - stepped.b) <= 2);
  }
}

}  // namespace
}  // namespace voxatlas
