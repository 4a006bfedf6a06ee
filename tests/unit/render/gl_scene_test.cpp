#include "render/gl_scene.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "render/frustum.hpp"
#include "scene.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// A cell of a scene as the oracle sees it: in camera coordinates.
struct SeenCell {
  Eigen::Vector3d centre;
  double edge;
};

std::vector<SeenCell> seen_cells(const Camera& camera, const Grid& grid,
                                 const std::vector<PlacedCloud>& clouds) {
  std::vector<SeenCell> cells;
  for (const auto& placed : clouds) {
    for (const DrawnCell& cell : placed.cloud->cells()) {
      const Eigen::Vector3d offset = cell.centre_voxels().cast<double>() / grid.cells_per_metre();
      cells.push_back(
          {camera.to_camera(grid.min_corner(placed.key) + offset), grid.cell_length(cell.depth)});
    }
  }
  return cells;
}

/// Where a ray (scaled to z = 1) enters a cell, as z; infinity where it does not.
double entry(const Eigen::Vector3d& ray, const SeenCell& cell, const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d direction = rotation.transpose() * ray;  // The cell is parallel to ECEF.
  const Eigen::Vector3d centre = rotation.transpose() * cell.centre;
  double in = 0, out = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (centre[axis] - cell.edge / 2) / direction[axis];
    const double b = (centre[axis] + cell.edge / 2) / direction[axis];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in <= out ? in : std::numeric_limits<double>::infinity();
}

/// How far a ray passes from a cell's middle, at the middle's own z.
Eigen::Vector2d miss(const Eigen::Vector3d& ray, const SeenCell& cell) {
  return (ray * cell.centre.z() - cell.centre).head<2>();
}

/// A brute-force caster over all cells says what each pixel must show: a ray that passes through
/// the inner ball of a cell must show it or something nearer, and what is shown must have its
/// splat there.
void check_against_caster(const test::Scene& scene, int depth, const Camera& camera) {
  const test::Clouds clouds(scene, depth);
  const auto cells = seen_cells(camera, scene.grid(), clouds.placed());
  auto gl = GlScene::create();
  REQUIRE(gl.has_value());
  const auto image = (*gl)->draw(camera, scene.grid(), clouds.placed());
  REQUIRE(image.has_value());
  std::size_t shown = 0, holes = 0, covered = 0, misplaced = 0;
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const Eigen::Vector3d ray = camera.ray(x + 0.5, y + 0.5);
      double nearest = std::numeric_limits<double>::infinity();
      for (const SeenCell& cell : cells) {
        if (cell.centre.z() < 2 || cell.centre.z() > camera.lens().far_range) continue;
        const double reach = 0.45 * cell.edge / ray.norm();
        if (miss(ray, cell).norm() < reach) nearest = std::min(nearest, cell.centre.z());
      }
      const std::size_t at = image->index(x, y);
      const std::uint32_t number = image->cell[at];
      holes += number == CellImage::kNone && std::isfinite(nearest);
      if (number == CellImage::kNone) continue;
      ++shown;
      const SeenCell& cell = cells[number - 1];
      const double z = image->z[at];
      // The depth of a 24-bit buffer, and the pixel's own half size, are the tolerances.
      const double step = z * z / camera.lens().near_range / (1 << 23) + 1e-4;
      covered += cell.centre.z() > 2 && z > nearest + step;
      const double pixel = z / std::min(camera.lens().fx, camera.lens().fy);
      const double splat = std::max(GlScene::kSplatScale / 2 * cell.edge, pixel) + 0.6 * pixel;
      const bool splat_here =
          miss(ray, cell).cwiseAbs().maxCoeff() <= splat && std::abs(z - cell.centre.z()) < step;
      const bool cube_here = std::abs(entry(ray, cell, camera.rotation()) - z) < 0.02 * z + step;
      misplaced += !splat_here && !cube_here && cell.centre.z() > 2;
    }
  }
  REQUIRE(shown > 500);
  REQUIRE(holes == 0);
  REQUIRE(covered == 0);
  REQUIRE(misplaced == 0);
}

TEST_CASE("each pixel shows the cell that a ray caster finds", "[gl][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  test::Scene scene;
  std::uniform_real_distribution<double> side(-9, 9);
  for (int i = 0; i < 250; ++i) scene.occupy({side(rng), 16 + side(rng), side(rng)});
  scene.occupy_box({-3, 20, -2}, {3, 20, 2});
  const Lens lens = Lens::of_view(48, 160, 120);
  for (const int depth : {7, 6, 5}) {
    check_against_caster(scene, depth, scene.camera({0, -2, 0}, {0, 10, 0}, lens).value());
    check_against_caster(scene, depth, scene.camera({4, -3, 6}, {0, 16, -1}, lens).value());
  }
}

TEST_CASE("a closed surface has no holes, however it lies to the grid", "[gl]") {
  test::Scene scene;
  for (int i = 0; i < 600 * 600; ++i) scene.occupy({i % 600 * 0.02 - 6, i / 600 * 0.02 - 6, 0});
  const test::Clouds clouds(scene, kDepth);
  auto gl = GlScene::create();
  for (const double height : {2.0, 6.0, 11.0}) {
    const auto camera = scene.camera({0, -4, height}, {0, 1, 0}, Lens::of_view(50, 320, 240));
    const auto image = (*gl)->draw(*camera, scene.grid(), clouds.placed());
    REQUIRE(image.has_value());
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const Eigen::Vector3d p = camera->rotation().transpose() * camera->ray(x + 0.5, y + 0.5);
        const Eigen::Vector3d p_enu = scene.frame().ecef_from_enu().rotation().transpose() * p;
        if (p_enu.z() >= 0) continue;
        const Eigen::Vector3d ground = Eigen::Vector3d(0, -4, height) - height / p_enu.z() * p_enu;
        if (ground.cwiseAbs().maxCoeff() > 5.8) continue;
        CAPTURE(height, x, y);
        REQUIRE(image->cell[image->index(x, y)] != CellImage::kNone);
        const double z = camera->to_camera(scene.frame().to_ecef(ground)).z();
        REQUIRE(std::abs(image->z[image->index(x, y)] - z) < 0.5 + 0.1 * z);
      }
    }
  }
}

TEST_CASE("what is nearer than near or farther than far is not drawn", "[gl]") {
  test::Scene scene;
  scene.occupy({0, 3, 0});
  scene.occupy({0, 30, 0});
  const test::Clouds clouds(scene, kDepth);
  auto gl = GlScene::create();
  const auto shown = [&](double near_range, double far_range) {
    Lens lens = Lens::of_view(40, 101, 101);
    lens.near_range = near_range;
    lens.far_range = far_range;
    const auto camera = scene.camera({0, 0, 0}, {0, 10, 0}, lens);
    const auto image = (*gl)->draw(*camera, scene.grid(), clouds.placed());
    const std::size_t middle = image->index(50, 50);
    return image->cell[middle] == CellImage::kNone ? 0.0 : double(image->z[middle]);
  };
  REQUIRE(shown(1, 100) == Approx(3).margin(0.1));
  REQUIRE(shown(5, 100) == Approx(30).margin(0.1));
  REQUIRE(shown(5, 20) == 0);
}

TEST_CASE("a cell as large as the picture is a cube, from outside and from inside", "[gl]") {
  test::Scene scene;
  scene.occupy({0, 10, 0});  // At depth 0 a whole tile.
  const test::Clouds clouds(scene, 0);
  const Grid& grid = scene.grid();
  const Box box = grid.box(scene.keys().front());
  const Eigen::Vector3d middle = (box.min + box.max) / 2;
  auto gl = GlScene::create();
  for (const double away : {60.0, 9.0, 7.0, 3.0, 0.0}) {
    const Eigen::Vector3d eye = middle - Eigen::Vector3d(away, 0, 0);
    const auto camera =
        Camera::look_at(eye, eye + Eigen::Vector3d::UnitX(), {0, 0, 1}, Lens::of_view(50, 64, 48));
    const auto image = (*gl)->draw(*camera, grid, clouds.placed());
    REQUIRE(image.has_value());
    const double face = away > 6.4 ? away - 6.4 : away + 6.4;  // Inside: the far wall.
    CAPTURE(away);
    REQUIRE(image->cell[image->index(32, 24)] == 1);
    if (away < 30) REQUIRE(image->z[image->index(32, 24)] == Approx(face).epsilon(1e-3));
  }
}

TEST_CASE("nothing in view is a picture of nothing", "[gl]") {
  const test::Scene scene;
  auto gl = GlScene::create();
  const auto camera = scene.camera({0, 0, 0}, {0, 10, 0}, Lens::of_view(40, 33, 17));
  const auto image = (*gl)->draw(*camera, scene.grid(), {});
  REQUIRE(image.has_value());
  REQUIRE(image->cell == std::vector<std::uint32_t>(33 * 17, CellImage::kNone));
  REQUIRE(std::isinf(image->z[100]));
}

TEST_CASE("one scene draws pictures of many sizes", "[gl]") {
  test::Scene scene;
  scene.occupy_box({-1, 5, -1}, {1, 5, 1});
  const test::Clouds clouds(scene, kDepth);
  auto gl = GlScene::create();
  for (const auto& [w, h] : {std::pair{1, 1}, {640, 400}, {2, 300}, {250, 10}}) {
    const Camera camera = scene.camera({0, 0, 0}, {0, 5, 0}, Lens::of_view(20, w, h)).value();
    const auto image = (*gl)->draw(camera, scene.grid(), clouds.placed());
    REQUIRE(image.has_value());
    REQUIRE(image->cell[image->index(w / 2, h / 2)] != CellImage::kNone);
  }
}

}  // namespace
}  // namespace voxatlas
