#include "render/gl_trees.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "forest.hpp"
#include "render/painter.hpp"
#include "scene.hpp"
#include "support/ray_caster.hpp"

namespace voxatlas {
namespace {

/// A cube's corners reach farther from its middle than its point does: there, the sky may show.
bool at_a_rim(const test::RayCaster& caster, const test::RayCaster::View& view,
              const Camera& camera, const test::RayCaster::Sight& sight, double x, double y,
              double edge) {
  const double pixels_a_metre = camera.lens().fx / (camera.orthographic() ? 1 : sight.z);
  const double step = 1 + 0.3 * edge * pixels_a_metre;
  return !caster.cast(view, x - step, y) || !caster.cast(view, x + step, y) ||
         !caster.cast(view, x, y - step) || !caster.cast(view, x, y + step);
}

/// A point is a square in the picture: what a ray meets at a pixel, or right beside it, is shown.
void check_against_caster(const test::Scene& scene, const Camera& camera, int depth) {
  const test::Forest forest(scene.tiles());
  const test::RayCaster caster(scene.grid(), scene.tiles(), depth);
  const test::RayCaster::View view(camera, scene.grid());
  auto gl = GlTrees::create();
  REQUIRE(gl.has_value());
  CellImage image;
  REQUIRE((*gl)->draw(camera, scene.grid(), forest.placed(), depth, image).has_value());
  const double edge = scene.grid().cell_length(depth);
  std::size_t shown = 0, holes = 0, far_off = 0, beside = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t at = image.index(x, y);
      const auto expected = caster.cast(view, x + 0.5, y + 0.5);
      if (image.cell[at] == CellImage::kNone) {
        holes += expected && !at_a_rim(caster, view, camera, *expected, x + 0.5, y + 0.5, edge);
        continue;
      }
      ++shown;
      // The cell is one of the model, where the picture says that it is.
      const auto& [tile, cell] = forest.cell(image.cell[at]);
      const Box box = scene.grid().box(tile, cell);
      const Eigen::Vector3d middle = camera.to_camera((box.min + box.max) / 2);
      const double z = static_cast<double>(image.z[at]);
      const double pixel = camera.orthographic() ? 1 / camera.lens().fx : z / camera.lens().fx;
      const double reach =
          0.9 * std::max(scene.grid().cell_length(cell.depth), 1.4 * pixel) + pixel;
      const Eigen::Vector2d off = (camera.point(x + 0.5, y + 0.5, middle.z()) - middle).head<2>();
      far_off += off.cwiseAbs().maxCoeff() > reach ||
                 std::abs(middle.z() - z) > 0.9 * scene.grid().cell_length(cell.depth);
      // A splat is larger than its cell, so it may stand before what the ray meets, not behind it.
      beside += expected && z > expected->z + 2 * edge;
    }
  }
  CAPTURE(depth, camera.orthographic(), shown, holes, far_off, beside);
  CHECK(shown > 1000);
  CHECK(holes == 0);
  CHECK(far_off == 0);
  CHECK(beside * 100 <= shown);
}

TEST_CASE("the gl backend shows what a ray caster over the tiles finds", "[gl][oracle]") {
  const test::Scene scene = test::street_scene();
  for (const int depth : {7, 5}) {
    check_against_caster(
        scene, scene.camera({-20, 0, 2}, {20, 0, 1}, Lens::of_view(50, 160, 120)).value(), depth);
    check_against_caster(
        scene, scene.camera({-30, -3, 14}, {0, 0, 0}, Lens::of_view(50, 160, 120)).value(), depth);
    check_against_caster(
        scene, scene.camera({-3, 0, 40}, {0, 0, 0}, Lens::of_map(6, 160, 120)).value(), depth);
  }
}

TEST_CASE("both backends paint nearly the same picture", "[gl][painter]") {
  const test::Scene scene = test::street_scene();
  const test::Forest forest(scene.tiles());
  const Camera camera = scene.camera({-20, 0, 2}, {20, 0, 1}, Lens::of_view(50, 320, 240)).value();
  Painter painter(1);
  Painting splat, gl;
  PaintOptions options;
  REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), options, splat).has_value());
  options.backend = Backend::kGl;
  REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), options, gl).has_value());
  REQUIRE(gl.depth == splat.depth);
  REQUIRE(gl.tiles == splat.tiles);
  REQUIRE(gl.cells_in_view == splat.cells_in_view);
  std::size_t close = 0;
  for (std::size_t i = 0; i < splat.image.pixels.size(); ++i) {
    const Rgb a = splat.image.pixels[i], b = gl.image.pixels[i];
    close += std::abs(a.r - b.r) < 40 && std::abs(a.g - b.g) < 40 && std::abs(a.b - b.b) < 40;
  }
  CAPTURE(close, splat.image.pixels.size());
  REQUIRE(close * 10 > splat.image.pixels.size() * 9);
}

TEST_CASE("backends have names", "[painter]") {
  for (const Backend backend : {Backend::kSplat, Backend::kGl}) {
    REQUIRE(backend_of(name_of(backend)).value() == backend);
  }
  const auto unknown = backend_of("vulkan");
  REQUIRE_FALSE(unknown.has_value());
  REQUIRE_THAT(unknown.error().message, Catch::Contains("vulkan") && Catch::Contains("splat, gl"));
  auto gl = GlTrees::create();
  CellImage image;
  const test::Scene scene;
  const Camera camera = scene.camera({0, 0, 0}, {0, 9, 0}, Lens::of_view(50, 16, 12)).value();
  REQUIRE_FALSE((*gl)->draw(camera, scene.grid(), {}, 8, image).has_value());
}

}  // namespace
}  // namespace voxatlas
