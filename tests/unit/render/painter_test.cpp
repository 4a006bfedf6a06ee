#include "render/painter.hpp"

#include <catch2/catch.hpp>

#include "forest.hpp"
#include "render/eye_dome.hpp"
#include "render/frustum.hpp"
#include "render/pacer.hpp"
#include "scene.hpp"

namespace voxatlas {
namespace {

constexpr int kWidth = 213, kHeight = 120;

struct Street {
  test::Scene scene = test::street_scene();
  test::Forest forest{scene.tiles()};
  Camera camera =
      scene.camera({-20, 0, 2}, {20, 0, 2.5}, Lens::of_view(60, kWidth, kHeight)).value();

  Painting paint(const PaintOptions& options, std::size_t threads = 2) {
    return paint(camera, options, threads);
  }
  Painting paint(const Camera& from, const PaintOptions& options, std::size_t threads = 2) {
    Painter painter(threads);
    Painting painting;
    REQUIRE(painter.paint(from, scene.grid(), forest.placed(), options, painting).has_value());
    return painting;
  }
};

TEST_CASE("a painting is the splatter's cells, shaded", "[painter]") {
  Street street;
  Splatter splatter(1);
  for (const double threshold : {0.0, 3.0}) {
    PaintOptions options;
    options.splat.pixel_threshold = threshold;
    options.fill_holes = threshold > 0;
    const Painting painting = street.paint(options);

    CellImage cells;
    const auto& trees = street.forest.placed();
    REQUIRE(
        splatter.draw(street.camera, street.scene.grid(), trees, options.splat, cells).has_value());
    if (options.fill_holes) fill_holes(cells);
    REQUIRE(painting.cells.cell == cells.cell);
    REQUIRE(painting.cells.z == cells.z);
    REQUIRE(painting.image.width == kWidth);
    REQUIRE(painting.image.height == kHeight);
    REQUIRE(painting.draw_ms > 0);
    REQUIRE(painting.shade_ms > 0);
  }
}

TEST_CASE("a painting says how deep it went and of how much", "[painter]") {
  Street street;
  for (const int depth : {0, 4, 7}) {
    PaintOptions options;
    options.splat.max_depth = depth;
    const Painting painting = street.paint(options);
    const Frustum frustum(street.camera);
    std::size_t tiles = 0;
    std::uint64_t cells = 0;
    for (const auto& placed : street.forest.placed()) {
      if (!frustum.may_see(street.scene.grid().box(placed.key))) continue;
      ++tiles;
      street.scene.tiles().at(placed.key).for_each_cell(depth, [&](const Leaf& leaf) {
        cells += is_occupied(leaf.state.log_odds);
      });
    }
    REQUIRE(tiles < street.forest.placed().size());
    REQUIRE(painting.depth == depth);
    REQUIRE(painting.tiles == tiles);
    REQUIRE(painting.cells_in_view == cells);
  }
  PaintOptions coarse;
  coarse.splat.pixel_threshold = 1e6;
  REQUIRE(street.paint(coarse).depth == 0);
}

TEST_CASE("trees out of view change no pixel", "[painter]") {
  Street street;
  const Frustum frustum(street.camera);
  std::vector<PlacedTree> seen;
  for (const auto& placed : street.forest.placed()) {
    if (frustum.may_see(street.scene.grid().box(placed.key))) seen.push_back(placed);
  }
  Painter painter(1);
  Painting painting;
  const auto& grid = street.scene.grid();
  REQUIRE(painter.paint(street.camera, grid, seen, {}, painting).has_value());
  REQUIRE(painting.image == street.paint({}).image);
}

TEST_CASE("refined at rest, a picture is the one that had no budget, to the bit", "[painter]") {
  Street street;
  const Painting full = street.paint({}, 1);
  Pacer pacer;
  Painter painter(2);
  Painting painting;
  // Too little for anything: the pacer begins at its lowest rung and climbs.
  REQUIRE(pacer.begin({0.01, kDepth, std::int64_t{kWidth} * kHeight, false}).has_value());
  int steps = 0, last_width = 0;
  while (const auto step = pacer.next()) {
    PaintOptions options;
    options.splat.max_depth = step->depth;
    options.splat.pixel_threshold = step->pixel_threshold;
    const Camera camera = step->shrink == 1 ? street.camera : street.camera.shrunk(step->shrink);
    REQUIRE(painter.paint(camera, street.scene.grid(), street.forest.placed(), options, painting)
                .has_value());
    pacer.measured(*step, painting.draw_ms + painting.shade_ms);
    REQUIRE(painting.image.width >= last_width);
    last_width = painting.image.width;
    if (steps++ == 0) REQUIRE_FALSE(painting.image == full.image);
    if (step->final) break;
  }
  REQUIRE(steps > 1);
  REQUIRE(painting.image == full.image);
  REQUIRE(painting.cells.z == full.cells.z);
}

TEST_CASE("a picture of nothing is sky", "[painter]") {
  const Street street;
  Painter painter(1);
  Painting painting;
  REQUIRE(painter.paint(street.camera, street.scene.grid(), {}, {}, painting).has_value());
  REQUIRE(painting.tiles == 0);
  REQUIRE(painting.cells_in_view == 0);
  REQUIRE(painting.image.at(kWidth / 2, 1).b > painting.image.at(kWidth / 2, 1).r);
}

TEST_CASE("the painter refuses what the splatter refuses", "[painter]") {
  const Street street;
  Painter painter(1);
  Painting painting;
  PaintOptions options;
  options.splat.max_depth = 8;
  const auto painted = painter.paint(street.camera, street.scene.grid(), {}, options, painting);
  REQUIRE_FALSE(painted.has_value());
  REQUIRE(painted.error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("of a street seen from above, the map is to scale", "[painter]") {
  Street street;
  const auto& scene = street.scene;
  // Four pixels a metre, north up: the facades stand 12 m apart, the street is 80 m long.
  Lens lens = Lens::of_map(4, 400, 100);
  const Camera map =
      Camera::look_at(scene.frame().to_ecef({0, 0, 50}), scene.frame().to_ecef({0, 0, 0}),
                      scene.frame().to_ecef({0, 1, 0}) - scene.frame().to_ecef({0, 0, 0}), lens)
          .value();
  const Painting painting = street.paint(map, {});
  int left = 400, right = 0, top = 100, bottom = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (painting.cells.cell[painting.cells.index(x, y)] == CellImage::kNone) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  REQUIRE(std::abs(left - (200 - 160)) <= 1);
  REQUIRE(std::abs(right - (200 + 160)) <= 1);
  REQUIRE(std::abs(top - (50 - 24)) <= 1);
  REQUIRE(std::abs(bottom - (50 + 24)) <= 1);
  // The ground 50 m below, the car's roof 1.5 m above it.
  const auto z_at = [&](double east, double north) {
    const int x = static_cast<int>(200 + 4 * east), y = static_cast<int>(50 - 4 * north);
    return static_cast<double>(painting.cells.z[painting.cells.index(x, y)]);
  };
  REQUIRE(z_at(-10, 0) == Approx(50).margin(0.2));
  REQUIRE(z_at(14, 4) == Approx(48.5).margin(0.2));
}

}  // namespace
}  // namespace voxatlas
