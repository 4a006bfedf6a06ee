#include "render/shade.hpp"

#include <catch2/catch.hpp>

#include "forest.hpp"
#include "render/painter.hpp"
#include "render/ramp.hpp"
#include "scene.hpp"

namespace voxatlas {
namespace {

TEST_CASE("colourings are known by name", "[shade]") {
  for (const auto colouring : {Colouring::kRgb, Colouring::kHeight, Colouring::kProbability,
                               Colouring::kLeafDepth, Colouring::kEllipsoid, Colouring::kNormal}) {
    REQUIRE(colouring_of(name_of(colouring)).value() == colouring);
  }
  const auto unknown = colouring_of("plaid");
  REQUIRE_FALSE(unknown.has_value());
  REQUIRE(unknown.error().code == ErrorCode::kInvalid);
  REQUIRE_THAT(unknown.error().message, Catch::Contains("plaid") && Catch::Contains("height"));
}

TEST_CASE("the ramp grows lighter all the way", "[ramp]") {
  const auto lightness = [](Rgb c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; };
  for (int i = 0; i < 100; ++i) {
    REQUIRE(lightness(ramp_colour(i / 100.0)) < lightness(ramp_colour((i + 1) / 100.0)));
  }
  REQUIRE(ramp_colour(-1) == ramp_colour(0));
  REQUIRE(ramp_colour(7) == ramp_colour(1));
}

TEST_CASE("the ground of a scene is low, and no single cell below it counts", "[shade]") {
  test::Scene scene = test::street_scene();
  scene.occupy({0, 0, -30});
  const test::Forest forest(scene.tiles());
  const auto camera = scene.camera({0, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200));
  const SceneHeights heights = scene_heights(*camera, scene.grid(), forest.placed());
  REQUIRE(heights.ground == Approx(-2).margin(0.4));
  REQUIRE(heights.up_ecef.dot(scene.frame().up_ecef()) > 0.999999);
}

TEST_CASE("a picture shows each thing in its colour, and sky above", "[shade]") {
  const test::Scene scene = test::street_scene();
  const test::Forest forest(scene.tiles());
  const auto camera = scene.camera({0, 0, 2}, {14, 3.5, 0.8}, Lens::of_view(60, 320, 200)).value();
  Painter painter(1);
  Painting rgb, other;
  REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), {}, rgb).has_value());
  const Rgb car = rgb.image.at(160, 100);
  REQUIRE(car.r > 2 * car.g);
  const Rgb sky = rgb.image.at(200, 2);
  REQUIRE(sky.b >= sky.r);
  for (const auto colouring : {Colouring::kHeight, Colouring::kProbability, Colouring::kLeafDepth,
                               Colouring::kEllipsoid, Colouring::kNormal}) {
    PaintOptions options;
    options.colouring = colouring;
    REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), options, other).has_value());
    REQUIRE_FALSE(other.image == rgb.image);
  }
}

}  // namespace
}  // namespace voxatlas
