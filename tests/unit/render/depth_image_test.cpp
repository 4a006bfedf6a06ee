#include "render/depth_image.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

namespace voxatlas {
namespace {

CellImage image_of(std::vector<float> z) {
  CellImage cells;
  cells.width = static_cast<int>(z.size());
  cells.height = 1;
  cells.cell.assign(z.size(), 1);
  cells.z = std::move(z);
  return cells;
}

TEST_CASE("a depth image in metres is the floats, least byte first", "[depth_image]") {
  const Bytes bytes = depth_metres(image_of({1.5f, CellImage::kNowhere}));
  REQUIRE(bytes == Bytes{0x00, 0x00, 0xc0, 0x3f, 0x00, 0x00, 0x80, 0x7f});
  REQUIRE(depth_metres(image_of({})).empty());
}

TEST_CASE("a depth image in steps counts them, and keeps nothing apart from near",
          "[depth_image]") {
  const auto bytes = depth_steps(
      image_of({CellImage::kNowhere, 0.001f, 0.0149f, 0.0151f, 2.58f, 655.35f, 2000.0f}), 0.01);
  REQUIRE(bytes.has_value());
  REQUIRE(*bytes == Bytes{0, 0, 1, 0, 1, 0, 2, 0, 2, 1, 0xff, 0xff, 0xff, 0xff});
}

TEST_CASE("a depth image has no steps without length", "[depth_image]") {
  for (const double step : {0.0, -0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto bytes = depth_steps(image_of({1}), step);
    REQUIRE_FALSE(bytes.has_value());
    REQUIRE(bytes.error().code == ErrorCode::kOutOfRange);
  }
}

}  // namespace
}  // namespace voxatlas
