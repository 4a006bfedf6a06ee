#include "render/frustum.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "geodesy/ecef.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

const Eigen::Vector3d kMunich = to_ecef({48.1493, 11.5685, 560}).value();

Camera random_camera(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> fov(20, 110), scale(2, 20);
  Lens lens =
      rng() % 3 == 0 ? Lens::of_map(scale(rng), 320, 200) : Lens::of_view(fov(rng), 320, 200);
  lens.cx += std::clamp(normal(rng) * 60, -180.0, 180.0);  // Off the middle, too.
  lens.far_range = std::uniform_real_distribution<double>(5, 300)(rng);
  const Eigen::Quaterniond q(normal(rng), normal(rng), normal(rng), normal(rng));
  return Camera::create(kMunich, q.normalized(), lens).value();
}

/// Oracle: a point is seen where it projects into the picture, between near and far.
bool sees(const Camera& camera, const Eigen::Vector3d& p_ecef) {
  const Eigen::Vector3d p = camera.to_camera(p_ecef);
  const Lens& lens = camera.lens();
  if (p.z() < lens.near_range || p.z() > lens.far_range) return false;
  const Eigen::Vector2d pixel = camera.to_pixel(p);
  return pixel.x() >= 0 && pixel.x() <= lens.width && pixel.y() >= 0 && pixel.y() <= lens.height;
}

/// Oracle: some of 9 x 9 x 9 points of the box are seen.
bool sees_some(const Camera& camera, const Box& box) {
  for (int i = 0; i < 729; ++i) {
    const Eigen::Vector3d t(i % 9 / 8.0, i / 9 % 9 / 8.0, i / 81 / 8.0);
    if (sees(camera, box.min + t.cwiseProduct(box.max - box.min))) return true;
  }
  return false;
}

TEST_CASE("a frustum never overlooks a box that has a point in view", "[frustum][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> size(0.1, 40);
  int seen = 0, overlooked = 0, in_vain = 0;
  for (int i = 0; i < 3000; ++i) {
    const Camera camera = random_camera(rng);
    const Eigen::Vector3d corner =
        kMunich + 60 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
    const Box box{corner, corner + Eigen::Vector3d(size(rng), size(rng), size(rng))};
    const bool truth = sees_some(camera, box);
    const bool said = Frustum(camera).may_see(box);
    seen += truth;
    overlooked += truth && !said;
    in_vain += said && !truth;
  }
  REQUIRE(overlooked == 0);
  REQUIRE(seen > 300);
  REQUIRE(in_vain < seen);  // It does cull.
}

TEST_CASE("tiles in view are those the frustum may see, nearest first", "[frustum][oracle]") {
  auto rng = test::engine();
  const Grid grid = Grid::standard();
  std::vector<TileKey> keys;
  const Index3 middle = grid.tile_at(kMunich).value().index();
  for (std::uint32_t i = 0; i < 1000; ++i) {
    keys.push_back(TileKey::from_index({middle[0] + i % 10 - 5, middle[1] + i / 10 % 10 - 5,
                                        middle[2] + i / 100 - 5})
                       .value());
  }
  std::shuffle(keys.begin(), keys.end(), rng);
  for (int i = 0; i < 20; ++i) {
    const Camera camera = random_camera(rng);
    const auto seen = tiles_in_view(camera, grid, keys);
    for (std::size_t k = 1; k < seen.size(); ++k) {
      REQUIRE(distance(grid.box(seen[k - 1]), kMunich) <= distance(grid.box(seen[k]), kMunich));
    }
    for (const TileKey key : keys) {
      const bool listed = std::find(seen.begin(), seen.end(), key) != seen.end();
      REQUIRE(listed == Frustum(camera).may_see(grid.box(key)));
    }
  }
}

TEST_CASE("the distance to a box is that of its nearest point", "[frustum][oracle]") {
  auto rng = test::engine();
  std::uniform_real_distribution<double> place(-5, 5);
  const Box box{{-1, -2, 0}, {2, 1, 3}};
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p(place(rng), place(rng), place(rng));
    double nearest = 1e9;
    for (int k = 0; k < 21 * 21 * 21; ++k) {
      const Eigen::Vector3d t(k % 21 / 20.0, k / 21 % 21 / 20.0, k / 441 / 20.0);
      nearest = std::min(nearest, (box.min + t.cwiseProduct(box.max - box.min) - p).norm());
    }
    REQUIRE(distance(box, p) <= nearest + 1e-12);
    REQUIRE(distance(box, p) > nearest - 0.3);
  }
}

TEST_CASE("the range of a box's tiles holds the tile of each of its points", "[frustum][oracle]") {
  auto rng = test::engine();
  const Grid grid = Grid::standard();
  std::uniform_real_distribution<double> size(0, 60), part(0, 1), side(-6.3e6, 6.3e6);
  for (int i = 0; i < 2000; ++i) {
    Box box{{side(rng), side(rng), side(rng)}, {}};
    if (i % 2 == 0) box.min = (box.min / 12.8).array().round() * 12.8;  // On borders.
    box.max = box.min + Eigen::Vector3d(size(rng), size(rng), size(rng));
    const Eigen::Vector3d p =
        box.min + Eigen::Vector3d(part(rng), part(rng), part(rng)).cwiseProduct(box.max - box.min);
    const Index3 tile = grid.tile_at(p).value().index();
    const TileRange range = tiles_of(grid, box);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      REQUIRE(tile[axis] >= range.min[axis]);
      REQUIRE(tile[axis] <= range.max[axis]);
    }
  }
}

TEST_CASE("a range of tiles ends at the cube's border", "[frustum]") {
  const Grid grid = Grid::standard();
  const TileRange range = tiles_of(grid, {{-9e6, 0, 6.399e6}, {-8e6, 10, 9e6}});
  REQUIRE(range.min[0] == 0);
  REQUIRE(range.max[0] == 0);
  REQUIRE(range.max[2] == grid.tiles_per_axis() - 1);
}

}  // namespace
}  // namespace voxatlas
