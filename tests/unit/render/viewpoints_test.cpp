#include "render/viewpoints.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "render/frustum.hpp"
#include "scene.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a street view stands in the street and looks along it", "[views]") {
  const test::Scene scene = test::street_scene();
  const test::Clouds clouds(scene, kDepth);
  REQUIRE_FALSE(street_tiles(scene.grid(), scene.weights()).empty());
  const auto camera = street_view(scene.grid(), scene.weights(), clouds.placed(), {});
  REQUIRE(camera.has_value());
  const Eigen::Vector3d eye = scene.frame().to_enu(camera->position());
  REQUIRE(std::abs(eye.x()) < 40);
  REQUIRE(std::abs(eye.y()) < 5);
  REQUIRE(eye.z() == Approx(2).margin(0.4));
  const Eigen::Vector3d ahead = scene.frame().ecef_from_enu().rotation().transpose() *
                                camera->rotation().transpose() * Eigen::Vector3d::UnitZ();
  REQUIRE(std::abs(ahead.x()) > 0.9);
}

TEST_CASE("an oblique view looks down on most of the model", "[views]") {
  const test::Scene scene = test::street_scene();
  const auto camera = oblique_view(scene.grid(), scene.weights(), {});
  REQUIRE(camera.has_value());
  REQUIRE(scene.frame().to_enu(camera->position()).z() > 20);
  const auto seen = tiles_in_view(*camera, scene.grid(), scene.keys());
  REQUIRE(seen.size() > scene.keys().size() * 3 / 4);
  // The street runs across the picture.
  const auto west = camera->to_pixel(camera->to_camera(scene.frame().to_ecef({-20, 0, 0})));
  const auto east = camera->to_pixel(camera->to_camera(scene.frame().to_ecef({20, 0, 0})));
  REQUIRE(std::abs(east.x() - west.x()) > 2 * std::abs(east.y() - west.y()));
}

TEST_CASE("a standing view looks where it is told", "[views]") {
  const test::Scene scene;
  const auto camera = standing_view({48.1493, 11.5685, 560}, 90, {});
  REQUIRE(camera.has_value());
  const auto p = camera->to_camera(scene.frame().to_ecef({10, 0, 0}));  // East.
  REQUIRE(p.z() == Approx(10).margin(1e-6));
  REQUIRE(p.head<2>().norm() < 1e-6);
}

TEST_CASE("a model with nothing in it has no views", "[views]") {
  const Grid grid = Grid::standard();
  REQUIRE(oblique_view(grid, {}, {}).error().code == ErrorCode::kNotFound);
  REQUIRE(street_view(grid, {}, {}, {}).error().code == ErrorCode::kNotFound);
  REQUIRE(street_tiles(grid, {}).empty());
  const test::Scene scene = test::street_scene();  // Occupied tiles, but none of them fetched.
  REQUIRE(street_view(scene.grid(), scene.weights(), {}, {}).error().code == ErrorCode::kNotFound);
}

TEST_CASE("views of no size and from nowhere are refused", "[views]") {
  const test::Scene scene = test::street_scene();
  REQUIRE_FALSE(oblique_view(scene.grid(), scene.weights(), {0, 720}).has_value());
  REQUIRE_FALSE(oblique_view(scene.grid(), scene.weights(), {1280, 0}).has_value());
  REQUIRE_FALSE(standing_view({91, 0, 0}, 0, {}).has_value());
  REQUIRE_FALSE(
      standing_view({48, 11, 0}, std::numeric_limits<double>::quiet_NaN(), {}).has_value());
}

}  // namespace
}  // namespace voxatlas
