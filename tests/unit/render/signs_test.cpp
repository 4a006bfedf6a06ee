#include "render/signs.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "scene.hpp"

namespace voxatlas {
namespace {

/// From above, north up, `pixels_a_metre`.
Camera map_of(const test::Scene& scene, double pixels_a_metre) {
  const auto& frame = scene.frame();
  return Camera::look_at(frame.to_ecef({0, 0, 50}), frame.to_ecef({0, 0, 0}), frame.north_ecef(),
                         Lens::of_map(pixels_a_metre, 640, 400))
      .value();
}

TEST_CASE("a round length is 1, 2 or 5 times a power of ten", "[signs]") {
  REQUIRE(round_length(1) == Approx(1));
  REQUIRE(round_length(1.99) == Approx(1));
  REQUIRE(round_length(2) == Approx(2));
  REQUIRE(round_length(4.9) == Approx(2));
  REQUIRE(round_length(73) == Approx(50));
  REQUIRE(round_length(1000) == Approx(1000));
  REQUIRE(round_length(0.03) == Approx(0.02));
}

TEST_CASE("a map's north is up, and its bar is as long as it says", "[signs]") {
  const test::Scene scene;
  const Camera map = map_of(scene, 4);
  const Stroke arrow = north_sign(map).front();
  const Eigen::Vector2f along = arrow.to - arrow.from;
  REQUIRE(std::abs(along.x()) < 0.01f);
  REQUIRE(along.y() == Approx(-40).margin(0.01));
  const Stroke bar = scale_sign(map, {}).front();  // A quarter of 640 pixels are 40 m: so 20 m.
  REQUIRE((bar.to - bar.from).norm() == Approx(80).margin(1e-3));
}

TEST_CASE("a view's bar is to scale at what its middle shows", "[signs]") {
  const test::Scene scene;
  const Camera camera = scene.camera({0, 0, 2}, {9, 0, 2}, Lens::of_view(60, 640, 400)).value();
  CellImage cells;
  cells.width = 640;
  cells.height = 400;
  cells.z.assign(640 * 400, 30);
  const Stroke bar = scale_sign(camera, cells).front();
  const double metres = (bar.to - bar.from).norm() * 30 / camera.lens().fx;
  REQUIRE(metres == Approx(round_length(metres)).epsilon(1e-4));
  cells.z.assign(640 * 400, CellImage::kNowhere);
  REQUIRE(scale_sign(camera, cells).empty());
}

TEST_CASE("the axes point where ECEF's do", "[signs]") {
  const test::Scene scene;
  const Camera camera = scene.camera({0, 0, 2}, {9, 4, 1}, Lens::of_view(60, 640, 400)).value();
  const Strokes strokes = axes_sign(camera);
  std::size_t arrows = 0;
  for (const Stroke& stroke : strokes) {
    if (stroke.from != strokes.front().from) continue;
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(arrows++));
    const Eigen::Vector3d seen = camera.rotation() * axis;
    const Eigen::Vector2d along = (stroke.to - stroke.from).cast<double>() / 36;
    REQUIRE((along - seen.head<2>()).norm() < 1e-4);
  }
  REQUIRE(arrows == 3);
}

TEST_CASE("text has a place for each letter, and lines for those it knows", "[signs]") {
  Strokes strokes;
  REQUIRE(add_text(strokes, "", {0, 0}, 12, {}) == 0);
  const float one = add_text(strokes, "8", {5, 40}, 12, {});
  REQUIRE(strokes.size() == 5);
  for (const Stroke& stroke : strokes) {
    for (const auto& end : {stroke.from, stroke.to}) {
      REQUIRE(end.x() >= 5);
      REQUIRE(end.x() <= 5 + one);
      REQUIRE(end.y() <= 40);
      REQUIRE(end.y() >= 28);
    }
  }
  Strokes gaps;
  REQUIRE(add_text(gaps, " ?m", {0, 0}, 12, {}) == Approx(3 * one));
  REQUIRE(gaps.size() == 5);  // The m alone.
}

}  // namespace
}  // namespace voxatlas
