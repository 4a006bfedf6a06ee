#include "render/supersample.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>

#include "scene.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("the rays of a supersampled pixel lie evenly within it", "[supersample]") {
  const test::Scene scene;
  for (const int side : {1, 2, 4}) {
    const Camera camera = scene.camera({0, 0, 0}, {0, 9, 1}, Lens::of_view(50, 7, 5)).value();
    Supersample mean(camera, side);
    std::set<std::pair<long, long>> places;
    Eigen::Vector2d sum(0, 0);
    while (!mean.complete()) {
      const Camera next = mean.next();
      // Where the ray through the middle of its pixel (3, 2) falls in the plain picture.
      const Eigen::Vector2d at = camera.to_pixel(next.ray(3.5, 2.5)) - Eigen::Vector2d(3, 2);
      REQUIRE((at.array() > 0).all());
      REQUIRE((at.array() < 1).all());
      places.emplace(std::lround(at.x() * 2 * side), std::lround(at.y() * 2 * side));
      REQUIRE(std::abs(at.x() * 2 * side - std::round(at.x() * 2 * side)) < 1e-9);
      sum += at;
      mean.add(Image(7, 5));
    }
    REQUIRE(places.size() == static_cast<std::size_t>(side * side));
    REQUIRE((sum / (side * side) - Eigen::Vector2d(0.5, 0.5)).norm() < 1e-12);
  }
}

TEST_CASE("a supersampled picture is the mean of its pictures", "[supersample][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::Scene scene;
  const Camera camera = scene.camera({0, 0, 0}, {0, 9, 1}, Lens::of_view(50, 31, 17)).value();
  std::uniform_int_distribution<int> level(0, 255);
  Supersample mean(camera);
  std::vector<double> red(31 * 17), blue(31 * 17);
  while (!mean.complete()) {
    Image image(31, 17);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const auto random = [&] { return static_cast<std::uint8_t>(level(rng)); };
      image.pixels[i] = {random(), 255, random()};
      red[i] += image.pixels[i].r / 16.0;
      blue[i] += image.pixels[i].b / 16.0;
    }
    mean.add(image);
  }
  const Image image = mean.image();
  REQUIRE(image.width == 31);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    REQUIRE(std::abs(image.pixels[i].r - red[i]) <= 0.5);
    REQUIRE(image.pixels[i].g == 255);
    REQUIRE(std::abs(image.pixels[i].b - blue[i]) <= 0.5);
  }
}

}  // namespace
}  // namespace voxatlas
