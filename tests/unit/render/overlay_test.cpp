#include "render/overlay.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "forest.hpp"
#include "render/painter.hpp"
#include "scene.hpp"

namespace voxatlas {
namespace {

constexpr int kWidth = 160, kHeight = 120;

bool differ(Rgb a, Rgb b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) > 6;
}

/// A wall across the view 20 m ahead, from the ground at -2 to 4 m.
struct Wall {
  test::Scene scene;
  Camera camera;
  std::vector<TileTree> tiles;
  std::vector<FreeCells> free_cells;
  std::vector<PlacedFree> free;

  explicit Wall(int width = kWidth, int height = kHeight)
      : camera(scene.camera({0, 0, 1}, {0, 9, 1}, Lens::of_view(50, width, height)).value()) {
    scene.occupy_box({-3, 20, -2}, {3, 20, 4}, Rgb{200, 40, 40});
  }

  /// A cube of free space around a place, a metre wide or so.
  void set_free(const Eigen::Vector3d& p_enu) {
    const VoxelIndex voxel = scene.grid().voxel_at(scene.frame().to_ecef(p_enu)).value();
    TileTree tile;
    tile.set(CellKey::of_voxel(Grid::in_tile(voxel), 4), {-800, {}});
    free_cells.emplace_back(tile, 4);
    free.push_back({scene.grid().tile_of(voxel), nullptr});
    for (std::size_t i = 0; i < free.size(); ++i) free[i].cells = &free_cells[i];
  }
  Painting paint(const PaintOptions& options) const {
    const test::Forest forest(scene.tiles());
    Painter painter(1);
    Painting painting;
    const auto painted = painter.paint(camera, scene.grid(), forest.placed(), options, painting);
    CAPTURE((painted ? std::string() : painted.error().message));
    REQUIRE(painted.has_value());
    return painting;
  }
};

TEST_CASE("a picture with nothing over it is left alone", "[overlay][gl]") {
  const Wall wall;
  auto overlay = Overlay::create();
  REQUIRE(overlay.has_value());
  Painting painting = wall.paint({});
  const Image before = painting.image;
  REQUIRE((*overlay)
              ->draw(wall.camera, wall.scene.grid(), {}, {}, painting.cells, painting.image)
              .has_value());
  REQUIRE(painting.image == before);
  // Through OpenGL and back, a picture keeps its bits where nothing is drawn.
  OverlayOptions boxes;
  boxes.tile_boxes = true;
  REQUIRE((*overlay)
              ->draw(wall.camera, wall.scene.grid(), {}, boxes, painting.cells, painting.image)
              .has_value());
  REQUIRE(painting.image == before);
}

TEST_CASE("free space before a wall shows through, behind it is hidden", "[overlay][gl]") {
  const auto changed = [](double north) {
    Wall wall;
    wall.set_free({0, north, 1});
    PaintOptions options;
    const Image before = wall.paint(options).image;
    options.free = wall.free;
    const Painting after = wall.paint(options);
    REQUIRE(after.overlay_ms > 0);
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (!differ(before.at(x, y), after.image.at(x, y))) continue;
        ++count;
        // The wall's red is still there, paler; nothing is covered.
        REQUIRE(after.image.at(x, y).r + 25 > after.image.at(x, y).b);
      }
    }
    return count;
  };
  const Wall wall;
  const double pixels_a_cell = wall.camera.lens().fx * 0.8 / 10;
  REQUIRE(changed(10) > 0.8 * pixels_a_cell * pixels_a_cell);
  REQUIRE(changed(10) < 6 * pixels_a_cell * pixels_a_cell);
  REQUIRE(changed(24) == 0);
}

TEST_CASE("a tile's box is drawn where its edges are", "[overlay][gl]") {
  test::Scene scene;
  scene.occupy({0, 40, 0});
  const TileKey key = scene.keys().front();
  const Box box = scene.grid().box(key);
  const Eigen::Vector3d middle = (box.min + box.max) / 2;
  for (const Lens& lens : {Lens::of_view(50, kWidth, kHeight), Lens::of_map(5, kWidth, kHeight)}) {
    const Camera camera =
        Camera::look_at(middle + Eigen::Vector3d(-31, -12, 9), middle, {0, 0, 1}, lens).value();
    const test::Forest forest(scene.tiles());
    Painter painter(1);
    Painting plain, boxed;
    PaintOptions options;
    REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), options, plain).has_value());
    options.overlay.tile_boxes = true;
    REQUIRE(painter.paint(camera, scene.grid(), forest.placed(), options, boxed).has_value());
    for (int axis = 0; axis < 3; ++axis) {
      for (int corner = 0; corner < 4; ++corner) {
        Eigen::Vector3d p = middle;  // The middle of an edge.
        p[(axis + 1) % 3] = (corner & 1) != 0 ? box.max[(axis + 1) % 3] : box.min[(axis + 1) % 3];
        p[(axis + 2) % 3] = (corner & 2) != 0 ? box.max[(axis + 2) % 3] : box.min[(axis + 2) % 3];
        const Eigen::Vector2d at = camera.to_pixel(camera.to_camera(p));
        const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
        REQUIRE((x > 1 && y > 1 && x < kWidth - 2 && y < kHeight - 2));
        bool near = false;
        for (int i = 0; i < 9; ++i) {
          const int u = x + i % 3 - 1, v = y + i / 3 - 1;
          near |= differ(plain.image.at(u, v), boxed.image.at(u, v));
        }
        CAPTURE(axis, corner, x, y);
        REQUIRE(near);
      }
    }
  }
}

TEST_CASE("axes, north and scale stand in three corners", "[overlay][gl]") {
  constexpr int kWide = 480, kHigh = 360;
  const Wall wall(kWide, kHigh);
  const Image plain = wall.paint({}).image;
  const auto changed = [&](auto choose, bool right, bool low) {
    PaintOptions options;
    choose(options.overlay);
    const Image image = wall.paint(options).image;
    std::size_t count = 0;
    for (int y = 0; y < kHigh; ++y) {
      for (int x = 0; x < kWide; ++x) {
        if (!differ(plain.at(x, y), image.at(x, y))) continue;
        ++count;
        REQUIRE((x >= kWide / 2) == right);
        REQUIRE((y >= kHigh / 2) == low);
      }
    }
    return count;
  };
  REQUIRE(changed([](OverlayOptions& o) { o.axes = true; }, false, true) > 40);
  REQUIRE(changed([](OverlayOptions& o) { o.north = true; }, true, false) > 20);
  REQUIRE(changed([](OverlayOptions& o) { o.scale = true; }, true, true) > 40);
}

TEST_CASE("free space of two depths is refused", "[painter]") {
  Wall wall;
  wall.set_free({0, 10, 1});
  const FreeCells coarse(TileTree{}, 2);
  wall.free.push_back({wall.free.front().key, &coarse});
  PaintOptions options;
  options.free = wall.free;
  Painter painter(1);
  Painting painting;
  const auto painted = painter.paint(wall.camera, wall.scene.grid(), {}, options, painting);
  REQUIRE_FALSE(painted.has_value());
  REQUIRE(painted.error().code == ErrorCode::kInvalid);
}

}  // namespace
}  // namespace voxatlas
