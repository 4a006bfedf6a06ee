#include "render/camera.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "geodesy/ecef.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

const Eigen::Vector3d kMunich = to_ecef({48.1493, 11.5685, 560}).value();

Eigen::Vector3d random_direction(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
}

TEST_CASE("a camera projects as its three axes say", "[camera][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> metres(0.5, 400);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d sight = random_direction(rng);
    const Eigen::Vector3d up = up_at(kMunich);
    const Lens lens = Lens::of_view(60, 640, 480);
    const auto camera = Camera::look_at(kMunich, kMunich + 20 * sight, up, lens);
    REQUIRE(camera.has_value());
    // Oracle: right, down and ahead by hand, a pixel by similar triangles.
    const Eigen::Vector3d right = sight.cross(up).normalized();
    const Eigen::Vector3d down = sight.cross(right);
    const Eigen::Vector3d p = kMunich + metres(rng) * (sight + 0.4 * random_direction(rng));
    const Eigen::Vector3d offset = p - kMunich;
    if (offset.dot(sight) < 0.1) continue;
    const double x = 320 + lens.fx * offset.dot(right) / offset.dot(sight);
    const double y = 240 + lens.fy * offset.dot(down) / offset.dot(sight);

    const Eigen::Vector3d p_camera = camera->to_camera(p);
    const Eigen::Vector2d pixel = camera->to_pixel(p_camera);

    REQUIRE(pixel.x() == Approx(x).margin(1e-4));
    REQUIRE(pixel.y() == Approx(y).margin(1e-4));
    REQUIRE((camera->ray(pixel.x(), pixel.y()) * p_camera.z() - p_camera).norm() < 1e-6);
    REQUIRE(camera->rotation().row(1).dot(up) <= 1e-12);  // Down is not up.
  }
}

TEST_CASE("a vertical field of view spans the picture's height", "[camera]") {
  const Lens lens = Lens::of_view(90, 1280, 720);
  REQUIRE(lens.fy == Approx(360));
  REQUIRE(lens.cx == 640);
}

TEST_CASE("a camera that looks straight down or up is still a camera", "[camera]") {
  const Eigen::Vector3d up = up_at(kMunich);
  for (const double sign : {1.0, -1.0}) {
    const auto camera =
        Camera::look_at(kMunich, kMunich + sign * 50 * up, up, Lens::of_view(60, 64, 48));
    REQUIRE(camera.has_value());
    const auto p = camera->to_camera(kMunich + sign * 50 * up);
    REQUIRE(p.z() == Approx(50));
    REQUIRE(p.head<2>().norm() < 1e-6);
  }
}

TEST_CASE("a camera's bounds hold everything it sees", "[camera][oracle]") {
  auto rng = test::engine();
  const auto camera = Camera::look_at(kMunich, kMunich + random_direction(rng), up_at(kMunich),
                                      Lens::of_view(70, 320, 200))
                          .value();
  const Box box = camera.bounds();
  std::uniform_real_distribution<double> x(0, 320), y(0, 200), z(0.3, 500);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p =
        camera.position() + camera.rotation().transpose() * (z(rng) * camera.ray(x(rng), y(rng)));
    REQUIRE(((p - box.min).array() >= -1e-6).all());
    REQUIRE(((box.max - p).array() >= -1e-6).all());
  }
}

TEST_CASE("an orthographic camera projects along its axis, to scale", "[camera][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::uniform_real_distribution<double> side(-30, 30);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d sight = random_direction(rng), up = up_at(kMunich);
    const auto camera =
        Camera::look_at(kMunich, kMunich + 20 * sight, up, Lens::of_map(8, 640, 480)).value();
    const Eigen::Vector3d right = sight.cross(up).normalized(), down = sight.cross(right);
    const double x = side(rng), y = side(rng), z = side(rng);
    const Eigen::Vector3d p = kMunich + x * right + y * down + z * sight;

    const Eigen::Vector3d p_camera = camera.to_camera(p);
    const Eigen::Vector2d pixel = camera.to_pixel(p_camera);

    REQUIRE(pixel.x() == Approx(320 + 8 * x).margin(1e-5));
    REQUIRE(pixel.y() == Approx(240 + 8 * y).margin(1e-5));
    REQUIRE((camera.point(pixel.x(), pixel.y(), z) - p_camera).norm() < 1e-6);
    REQUIRE(camera.ray(pixel.x(), pixel.y()) == Eigen::Vector3d(0, 0, 1));
  }
}

TEST_CASE("a shrunk camera sees the same on fewer pixels, a shifted one beside them", "[camera]") {
  for (const Lens& lens : {Lens::of_view(60, 641, 480), Lens::of_map(7, 641, 480)}) {
    const auto camera =
        Camera::look_at(kMunich, kMunich + Eigen::Vector3d(3, 4, 5), up_at(kMunich), lens).value();
    const Camera small = camera.shrunk(4), beside = camera.shifted(0.25, -0.5);
    REQUIRE(small.width() == 161);
    REQUIRE(small.height() == 120);
    REQUIRE((small.point(100, 50, 9) - camera.point(400, 200, 9)).norm() < 1e-9);
    REQUIRE((beside.point(100, 50, 9) - camera.point(100.25, 49.5, 9)).norm() < 1e-9);
    REQUIRE(beside.position() == camera.position());
  }
}

TEST_CASE("no camera that is let through sees more than 20 km", "[camera]") {
  Lens lens = Lens::of_view(60, 640, 480);
  lens.far_range = Camera::kMaxRange;
  lens.fx = 320 / Camera::kMaxSlope;
  lens.fy = 240 / Camera::kMaxSlope;
  const auto widest =
      Camera::look_at(kMunich, kMunich + Eigen::Vector3d(3, 4, 5), up_at(kMunich), lens);
  REQUIRE(widest.has_value());
  const Box box = widest->bounds();
  REQUIRE((box.max - box.min).maxCoeff() < 10 * Camera::kMaxRange * 1.5);
}

TEST_CASE("degenerate cameras are refused, with the value", "[camera]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Lens good = Lens::of_view(60, 640, 480);
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  REQUIRE(Camera::create(kMunich, level, good).has_value());

  const auto refused = [&](const Eigen::Vector3d& p, const Eigen::Quaterniond& q, const Lens& lens,
                           const std::string& word) {
    const auto camera = Camera::create(p, q, lens);
    REQUIRE_FALSE(camera.has_value());
    REQUIRE(camera.error().code == ErrorCode::kOutOfRange);
    REQUIRE_THAT(camera.error().message, Catch::Contains(word));
  };
  refused({nan, 0, 0}, level, good, "nan");
  refused({0, inf, 0}, level, good, "inf");
  refused({0, 0, 1e9}, level, good, "1000000000");
  refused(kMunich, Eigen::Quaterniond(0, 0, 0, 0), good, "length 0");
  refused(kMunich, Eigen::Quaterniond(nan, 0, 0, 1), good, "nan");
  refused(kMunich, Eigen::Quaterniond(2, 0, 0, 0), good, "length 2");
  const auto bad_lens = [&](auto change, const std::string& word) {
    Lens lens = good;
    change(lens);
    refused(kMunich, level, lens, word);
  };
  bad_lens([](Lens& l) { l.width = 0; }, "0 x 480");
  bad_lens([](Lens& l) { l.height = -3; }, "640 x -3");
  bad_lens([](Lens& l) { l.width = 100'000; }, "100000 x 480");
  bad_lens([](Lens& l) { l.width = l.height = 8192; }, "more than 33554432 pixels");
  bad_lens([&](Lens& l) { l.fx = nan; }, "nan");
  bad_lens([](Lens& l) { l.fy = 0; }, "focal length of 0");
  bad_lens([&](Lens& l) { l.cx = inf; }, "principal point");
  bad_lens([](Lens& l) { l.fx = 0.01; }, "a view that opens 32000 m");
  bad_lens([](Lens& l) { l.cy = -8000; }, "a view that opens 20.39");
  bad_lens(
      [](Lens& l) {
        l.projection = Projection::kOrthographic;
        l.fx = 0.1;
      },
      "a map that reaches 3200 m");
  bad_lens([](Lens& l) { l.near_range = 0; }, "near 0");
  bad_lens([](Lens& l) { l.near_range = -1; }, "near -1");
  bad_lens([](Lens& l) { l.far_range = 0.1; }, "far 0.1");
  bad_lens([](Lens& l) { l.far_range = 3000; }, "far 3000");
  bad_lens([&](Lens& l) { l.far_range = nan; }, "nan");
}

TEST_CASE("looking at oneself, at nothing, or with no up is refused", "[camera]") {
  const Lens lens = Lens::of_view(60, 640, 480);
  const Eigen::Vector3d up = up_at(kMunich);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(Camera::look_at(kMunich, kMunich, up, lens).has_value());
  REQUIRE_FALSE(Camera::look_at(kMunich, {nan, 0, 0}, up, lens).has_value());
  REQUIRE_FALSE(Camera::look_at({0, nan, 0}, kMunich, up, lens).has_value());
  REQUIRE_FALSE(Camera::look_at(kMunich, kMunich + up, {0, 0, 0}, lens).has_value());
  REQUIRE_FALSE(Camera::look_at(kMunich, kMunich + up, {0, nan, 0}, lens).has_value());
}

}  // namespace
}  // namespace voxatlas
