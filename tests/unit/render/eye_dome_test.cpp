#include "render/eye_dome.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace voxatlas {
namespace {

CellImage image_of(int width, int height, float (*z)(int, int)) {
  CellImage image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.z.push_back(z(x, y));
      image.cell.push_back(std::isinf(image.z.back()) ? CellImage::kNone : 1);
    }
  }
  return image;
}

TEST_CASE("a plane keeps its full light, however it is tilted", "[eye_dome]") {
  // A plane in view: 1/z is linear in the pixels.
  const auto level = image_of(60, 40, [](int, int) { return 12.0f; });
  const auto wall = image_of(60, 40, [](int x, int) { return 1 / (0.1f + 0.002f * float(x)); });
  const auto road = image_of(60, 40, [](int, int y) { return 1 / (0.002f + 0.004f * float(y)); });
  for (const auto& image : {level, wall, road}) {
    for (const float light : eye_dome_light(image, 0.001f)) REQUIRE(light == 1.0f);
  }
}

TEST_CASE("what stands behind an edge is darker at it, what stands before it is not",
          "[eye_dome]") {
  const auto image = image_of(60, 40, [](int x, int) { return x < 30 ? 5.0f : 10.0f; });
  const auto light = eye_dome_light(image, 0.05f);
  REQUIRE(light[image.index(29, 20)] == 1.0f);
  REQUIRE(light[image.index(30, 20)] < 0.6f);
  REQUIRE(light[image.index(30, 20)] >= kDarkest);
  REQUIRE(light[image.index(45, 20)] == 1.0f);
}

TEST_CASE("steps below the roughness cast no shade, and the sky none at all", "[eye_dome]") {
  const auto rough =
      image_of(60, 40, [](int x, int y) { return 10.0f + ((x + y) % 2 == 0 ? 0.04f : 0.0f); });
  for (const float light : eye_dome_light(rough, 0.05f)) REQUIRE(light == 1.0f);
  const auto sky =
      image_of(60, 40, [](int x, int) { return x < 30 ? 10.0f : CellImage::kNowhere; });
  for (const float light : eye_dome_light(sky, 0.05f)) REQUIRE(light == 1.0f);
}

TEST_CASE("a picture of one pixel has light", "[eye_dome]") {
  const auto image = image_of(1, 1, [](int, int) { return 3.0f; });
  REQUIRE(eye_dome_light(image, 0.1f) == std::vector<float>{1.0f});
}

TEST_CASE("a hole in a surface is closed, an edge and a gap are left", "[eye_dome]") {
  auto image = image_of(60, 40, [](int x, int) { return x < 30 ? 5.0f : CellImage::kNowhere; });
  image.z[image.index(10, 10)] = 50;  // Seen through the surface.
  image.cell[image.index(10, 10)] = 7;
  for (int y = 20; y < 23; ++y) {
    for (int x = 10; x < 13; ++x) image.z[image.index(x, y)] = CellImage::kNowhere;
  }
  REQUIRE(fill_holes(image) == 1);
  REQUIRE(image.z[image.index(10, 10)] == 5.0f);
  REQUIRE(image.cell[image.index(10, 10)] == 1);
  REQUIRE(std::isinf(image.z[image.index(11, 21)]));
  REQUIRE(std::isinf(image.z[image.index(30, 10)]));
}

}  // namespace
}  // namespace voxatlas
